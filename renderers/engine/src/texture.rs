//! A decoded frame in a 3-D texture: what the site *host* draws from.

use cvr_core::codec::{DecodedForm, TexelFormat};
use cvr_core::shader::TextureSampling;
use cvr_core::volume::VolumeLayout;

use crate::texels::{texels, texture_channels};
use crate::upload::SLAB_BYTES;
use crate::{Device, EngineError, TextureChoice};

/// A decoded frame on the device. Clones share the texture.
#[derive(Clone, Debug)]
pub struct VolumeTexture {
    layout: VolumeLayout,
    choice: TextureChoice,
    view: wgpu::TextureView,
    bytes: u64,
}

impl VolumeTexture {
    /// Uploads one frame: `values` in data units, x fastest, channels interleaved. `form` is the decoder's.
    ///
    /// # Errors
    /// As [`crate::Capabilities::texture`]; [`EngineError::Unsupported`] when the number of values does not fit
    /// the layout; out of memory and what else the driver refuses.
    pub fn upload(
        device: &Device,
        layout: &VolumeLayout,
        values: &[f32],
        form: DecodedForm,
    ) -> Result<Self, EngineError> {
        let choice = device.capabilities().texture(form, layout.extent)?;
        Self::upload_as(device, layout, values, choice)
    }

    /// As [`VolumeTexture::upload`], the decision being made.
    pub(crate) fn upload_as(
        device: &Device,
        layout: &VolumeLayout,
        values: &[f32],
        choice: TextureChoice,
    ) -> Result<Self, EngineError> {
        if values.len() as u64 != layout.samples_per_frame() {
            return Err(EngineError::Unsupported(format!(
                "{} values for a frame of {} samples",
                values.len(),
                layout.samples_per_frame()
            )));
        }
        let [width, height, depth] = layout.extent.to_array();
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: depth };
        let descriptor = wgpu::TextureDescriptor {
            label: Some("volume"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format: texture_format(choice.form.format, layout.channels),
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        };
        let texel_bytes = texture_channels(layout.channels) * choice.form.format.bytes();
        let slice_texels = width as usize * height as usize;
        let slices = (SLAB_BYTES / (slice_texels * texel_bytes)).max(1);
        device.guarded("uploading a volume texture", || {
            let texture = device.wgpu().create_texture(&descriptor);
            let slab_values = slice_texels * layout.channels as usize * slices;
            for (i, slab) in values.chunks(slab_values).enumerate() {
                let bytes = texels(slab, layout.channels, choice.form);
                let first = i * slices;
                let target = wgpu::TexelCopyTextureInfo {
                    texture: &texture,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x: 0, y: 0, z: first as u32 },
                    aspect: wgpu::TextureAspect::All,
                };
                let rows = wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(width * texel_bytes as u32),
                    rows_per_image: Some(height),
                };
                let slab_depth = slices.min(depth as usize - first) as u32;
                let slab_size = wgpu::Extent3d { depth_or_array_layers: slab_depth, ..size };
                device.queue().write_texture(target, &bytes, rows, slab_size);
                device.flush(values.len() > slab_values)?;
            }
            Ok(Self {
                layout: layout.clone(),
                choice,
                view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
                bytes: layout.extent.voxels() * texel_bytes as u64,
            })
        })
    }

    /// The same texture, to be filtered by the shader even where the texture unit could.
    #[must_use]
    pub fn with_manual_sampling(&self) -> Self {
        let choice = TextureChoice { sampling: TextureSampling::Manual, ..self.choice };
        Self { choice, ..self.clone() }
    }

    /// Shape of the volume that the frame belongs to.
    #[must_use]
    pub const fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    /// Form and sampling that shaders are to be generated with, and the fallback in use, if any.
    #[must_use]
    pub const fn choice(&self) -> TextureChoice {
        self.choice
    }

    /// Bytes of its texels.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(crate) const fn view(&self) -> &wgpu::TextureView {
        &self.view
    }
}

const fn texture_format(format: TexelFormat, channels: u32) -> wgpu::TextureFormat {
    match (format, texture_channels(channels)) {
        (TexelFormat::Unorm8, 1) => wgpu::TextureFormat::R8Unorm,
        (TexelFormat::Unorm8, _) => wgpu::TextureFormat::Rgba8Unorm,
        (TexelFormat::Unorm16, 1) => wgpu::TextureFormat::R16Unorm,
        (TexelFormat::Unorm16, _) => wgpu::TextureFormat::Rgba16Unorm,
        (TexelFormat::Float16, 1) => wgpu::TextureFormat::R16Float,
        (TexelFormat::Float16, _) => wgpu::TextureFormat::Rgba16Float,
        (TexelFormat::Float32, 1) => wgpu::TextureFormat::R32Float,
        (TexelFormat::Float32, _) => wgpu::TextureFormat::Rgba32Float,
    }
}

#[cfg(test)]
mod tests;
