//! A decoded frame in a 3-D texture, for the sites *host* and *deferred*; or four layers, for the site *ring*.

use std::sync::Arc;

use cvr_core::codec::{BlockFormat, DecodedForm, TexelFormat};
use cvr_core::shader::{Source, TextureSampling};
use cvr_core::volume::VolumeLayout;

use crate::slabs::Slabs;
use crate::texels::{texels, texture_channels, values};
use crate::upload::SLAB_BYTES;
use crate::{Capabilities, Device, EngineError, TextureChoice};

/// A decoded frame on the device. Clones share the texture.
#[derive(Clone, Debug)]
pub struct VolumeTexture {
    layout: VolumeLayout,
    choice: TextureChoice,
    /// Format of the blocks that the texture unit decodes. `None` if texels are stored singly.
    blocks: Option<BlockFormat>,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    /// The buffers from which the texels were decoded.
    kept: Arc<[wgpu::Buffer]>,
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
        let empty = Self::empty(device, layout, choice)?;
        let [width, height, depth] = layout.extent.to_array();
        let texel_bytes = empty.texel_bytes();
        let slice_texels = width as usize * height as usize;
        let slices = (SLAB_BYTES / (slice_texels * texel_bytes)).max(1);
        device.guarded("uploading a volume texture", || {
            let slab_values = slice_texels * layout.channels as usize * slices;
            for (i, slab) in values.chunks(slab_values).enumerate() {
                let bytes = texels(slab, layout.channels, choice.form);
                let first = i * slices;
                let rows = wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(width * texel_bytes as u32),
                    rows_per_image: Some(height),
                };
                let slab_depth = slices.min(depth as usize - first) as u32;
                let slab_size = wgpu::Extent3d { width, height, depth_or_array_layers: slab_depth };
                device.queue().write_texture(empty.place(0, first as u32), &bytes, rows, slab_size);
                device.flush(values.len() > slab_values)?;
            }
            Ok(())
        })?;
        Ok(empty)
    }

    /// A texture whose texels are zero.
    pub(crate) fn empty(
        device: &Device,
        layout: &VolumeLayout,
        choice: TextureChoice,
    ) -> Result<Self, EngineError> {
        let format = texture_format(choice.form.format, layout.channels);
        Self::of_format(device, layout, choice, (format, None))
    }

    /// A texture of single texels, or of blocks. With blocks, its size is a whole number of blocks.
    pub(crate) fn of_format(
        device: &Device,
        layout: &VolumeLayout,
        choice: TextureChoice,
        (format, blocks): (wgpu::TextureFormat, Option<BlockFormat>),
    ) -> Result<Self, EngineError> {
        let [width, height, depth] =
            blocks.map_or_else(|| layout.extent.to_array(), |blocks| blocks.padded(layout.extent));
        let descriptor = wgpu::TextureDescriptor {
            label: Some("volume"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: depth },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_DST
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        };
        device.guarded("making a volume texture", || {
            let texture = device.wgpu().create_texture(&descriptor);
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            Ok(Self { layout: layout.clone(), choice, blocks, texture, view, kept: Arc::default() })
        })
    }

    /// The same texture. It keeps these buffers on the device while it lives.
    pub(crate) fn keeping(self, buffers: Vec<wgpu::Buffer>) -> Self {
        Self { kept: buffers.into(), ..self }
    }

    /// All samples in the texture (x fastest, channels interleaved, data units). A texel of 8 or 16 bits gives its
    /// exact step, without a device's rounding in the conversion to a number. For blocks, a shader loads the values
    /// that the texture unit decodes.
    ///
    /// # Errors
    /// [`EngineError::TooLarge`] if not even one row fits into a buffer, or if the whole texture does not fit on a
    /// device whose copies must begin at the first slice; and errors of the driver.
    pub fn read(&self, device: &Device) -> Result<Vec<f32>, EngineError> {
        if self.blocks.is_some() {
            return self.load(device);
        }
        let Capabilities { buffer_bytes, copies_from_any_slice, .. } = *device.capabilities();
        let whole = Slabs::new(self.layout.extent, self.texel_bytes(), u64::MAX)?;
        if copies_from_any_slice {
            let most_bytes = buffer_bytes.min(SLAB_BYTES as u64);
            return self.read_slabs(device, Slabs::new(self.layout.extent, self.texel_bytes(), most_bytes)?);
        }
        // The single copy that begins at the first slice and ends with the last.
        if whole.most_bytes() > buffer_bytes {
            return Err(EngineError::TooLarge {
                what: "reading a texture on a device that copies slices from the first one on alone"
                    .to_owned(),
                requested: whole.most_bytes(),
                limit: buffer_bytes,
                unit: "bytes in one buffer",
            });
        }
        self.read_slabs(device, whole)
    }

    /// As [`VolumeTexture::read`] for single texels, in these pieces.
    pub(crate) fn read_slabs(&self, device: &Device, slabs: Slabs) -> Result<Vec<f32>, EngineError> {
        let mut all = Vec::with_capacity(self.layout.samples_per_frame() as usize);
        for slab in slabs.iter() {
            let bytes: Vec<u8> = device.guarded("reading a volume texture", || {
                let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
                let staging = device.empty_buffer("texels", usage, slabs.bytes(slab))?;
                let mut encoder =
                    device.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let target =
                    wgpu::TexelCopyBufferInfo { buffer: &staging, layout: slabs.buffer_layout(slab) };
                let place = self.place(slab.first_row, slab.first_slice);
                encoder.copy_texture_to_buffer(place, target, slabs.size(slab));
                device.queue().submit([encoder.finish()]);
                device.map_and_read(&staging)
            })?;
            for row in bytes.chunks_exact(slabs.row_bytes()) {
                let row = &row[..self.layout.extent.x() as usize * self.texel_bytes()];
                values(row, self.layout.channels, self.choice.form, &mut all);
            }
        }
        Ok(all)
    }

    /// The same texture, filtered by the shader even if the texture unit could.
    #[must_use]
    pub fn with_manual_sampling(&self) -> Self {
        let choice = TextureChoice { sampling: TextureSampling::Manual, ..self.choice };
        Self { choice, ..self.clone() }
    }

    /// Shape of the frame's volume.
    #[must_use]
    pub const fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    /// Form and sampling for the shader generator, and the fallback, if one is used.
    #[must_use]
    pub const fn choice(&self) -> TextureChoice {
        self.choice
    }

    /// Format of the blocks that the texture unit decodes. `None` if texels are stored singly.
    #[must_use]
    pub const fn blocks(&self) -> Option<BlockFormat> {
        self.blocks
    }

    /// As the shader generator wants it.
    pub(crate) fn source(&self) -> Source<'static> {
        let TextureChoice { form, sampling, .. } = self.choice;
        let padded = self.blocks.map(|blocks| blocks.padded(self.layout.extent));
        let padded = padded.filter(|size| *size != self.layout.extent.to_array());
        Source::Texture { form, sampling, padded }
    }

    /// Bytes of its texels, or of its blocks.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        if let Some(blocks) = self.blocks {
            return blocks.bytes(self.layout.extent);
        }
        self.layout.extent.voxels() * self.texel_bytes() as u64
    }

    /// Bytes that stay on the device with it: its texels and, if the device decoded them, the codec's buffers, from
    /// which it can decode again. The buffer that moves texels from shader to texture is freed by then.
    #[must_use]
    pub fn resident_bytes(&self) -> u64 {
        self.bytes() + self.kept.iter().map(wgpu::Buffer::size).sum::<u64>()
    }

    /// Bytes of one texel that is not part of a block.
    pub(crate) const fn texel_bytes(&self) -> usize {
        texture_channels(self.layout.channels) * self.choice.form.format.bytes()
    }

    /// The texels from a row of a slice on, for copies.
    pub(crate) fn place(&self, row: u32, slice: u32) -> wgpu::TexelCopyTextureInfo<'_> {
        wgpu::TexelCopyTextureInfo {
            texture: &self.texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x: 0, y: row, z: slice },
            aspect: wgpu::TextureAspect::All,
        }
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
