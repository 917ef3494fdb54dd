//! What a picture is drawn into, the pass that blends into it, and how it comes back.

use cvr_core::render::{Blending, Image};
use half::f16;

use crate::{Device, EngineError};

/// The target of a picture.
#[derive(Debug)]
pub(crate) enum Canvas {
    /// Premultiplied RGBA in rows, written by compute passes.
    Buffer(wgpu::Buffer),
    /// A render target, for passes that blend.
    Target(wgpu::Texture),
}

/// The part of a picture that a device did not draw.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(crate) struct CutOff {
    /// Pixels whose rays were cut off.
    pub(crate) pixels: usize,
    /// Lowest number of a sample at which a ray was cut off. If all rays were at their ends, the highest.
    pub(crate) sample: u32,
}

impl CutOff {
    /// The cut-off part of a picture. `None` if everything was drawn. Only a ray that was cut off has a negative
    /// opacity ([`cvr_core::render::RayWalk`]).
    fn of(pixels: &[[f32; 4]]) -> Option<Self> {
        let cut = || pixels.iter().filter(|pixel| pixel[3] < 0.0);
        let sample = |pixel: &[f32; 4]| pixel[0] as u32;
        // Threads that run together are ended together. Rays at their ends next to a long one are short and irrelevant.
        let unfinished = cut().filter(|pixel| pixel[1] > 0.0).map(sample).min();
        let longest = cut().map(sample).max()?;
        Some(Self { pixels: cut().count(), sample: unfinished.unwrap_or(longest) })
    }
}

/// Rows of a copy between texture and buffer.
const ROW_BYTES: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;

impl Canvas {
    /// A transparent picture that compute passes write.
    pub(crate) fn buffer(device: &Device, size: [u32; 2]) -> Result<Self, EngineError> {
        let bytes = bytes_of(size, size_of::<[f32; 4]>() as u64)?;
        let limit = device.capabilities().storage_bytes();
        if bytes > limit {
            return Err(too_large(size, bytes, limit, "bytes in one buffer"));
        }
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        device.guarded("making a picture", || device.empty_buffer("image", usage, bytes)).map(Self::Buffer)
    }

    /// A transparent picture that passes blend into.
    pub(crate) fn target(
        device: &Device,
        size: [u32; 2],
        format: wgpu::TextureFormat,
    ) -> Result<Self, EngineError> {
        bytes_of(size, 1)?;
        let longest = size[0].max(size[1]);
        let limit = device.capabilities().picture_edge_pixels;
        if longest > limit {
            return Err(too_large(size, u64::from(longest), u64::from(limit), "pixels along one side"));
        }
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let texture = device.guarded("making a picture", || {
            Ok(device.wgpu().create_texture(&wgpu::TextureDescriptor {
                label: Some("image"),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            }))
        })?;
        Ok(Self::Target(texture))
    }

    /// Precision of blended sums. `None` if nothing is blended.
    pub(crate) fn blending(&self) -> Option<Blending> {
        match self {
            Self::Buffer(_) => None,
            Self::Target(texture) if texture.format() == wgpu::TextureFormat::Rgba16Float => {
                Some(Blending::Float16)
            }
            Self::Target(_) => Some(Blending::Float32),
        }
    }

    /// The part of the current picture that the device did not draw.
    pub(crate) fn cut_off(&self, device: &Device) -> Result<Option<CutOff>, EngineError> {
        match self {
            Self::Buffer(buffer) => Ok(CutOff::of(&device.read_buffer(buffer, buffer.size())?)),
            Self::Target(_) => Ok(None),
        }
    }

    /// Pixels whose red is below zero, which no light is.
    pub(crate) fn below_zero(&self, device: &Device) -> Result<usize, EngineError> {
        let pixels = self.pixels(device)?;
        Ok(pixels.iter().filter(|pixel| pixel[0] < 0.0).count())
    }

    /// Its current pixels.
    pub(crate) fn pixels(&self, device: &Device) -> Result<Vec<[f32; 4]>, EngineError> {
        match self {
            Self::Buffer(buffer) => device.read_buffer(buffer, buffer.size()),
            Self::Target(texture) => read_texture(device, texture),
        }
    }

    /// The current picture.
    pub(crate) fn read(&self, device: &Device, size: [u32; 2]) -> Result<Image, EngineError> {
        let pixels = self.pixels(device)?;
        if let Some(CutOff { pixels, .. }) = CutOff::of(&pixels) {
            return Err(EngineError::CutOff { pixels });
        }
        Image::from_pixels(size, pixels)
            .ok_or_else(|| EngineError::Gpu("the picture came back in another size".to_owned()))
    }
}

/// Begins a pass that blends into a picture. With `clear` the picture is made transparent first.
pub(crate) fn blend<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    clear: bool,
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
) -> wgpu::RenderPass<'e> {
    let load = if clear { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load };
    let attachment = wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
    };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("draw"),
        color_attachments: &[Some(attachment)],
        depth_stencil_attachment: None,
        timestamp_writes,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}

fn read_texture(device: &Device, texture: &wgpu::Texture) -> Result<Vec<[f32; 4]>, EngineError> {
    let half = texture.format() == wgpu::TextureFormat::Rgba16Float;
    let texel_bytes = if half { 8 } else { 16 };
    let size = texture.size();
    let row_bytes = (size.width * texel_bytes).next_multiple_of(ROW_BYTES);
    let bytes: Vec<u8> = device.guarded("reading a picture back", || {
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let staging =
            device.empty_buffer("read-back", usage, u64::from(row_bytes) * u64::from(size.height))?;
        let mut encoder = device.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None };
        let target = wgpu::TexelCopyBufferInfo { buffer: &staging, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), target, size);
        device.queue().submit([encoder.finish()]);
        device.map_and_read(&staging)
    })?;
    let rows = bytes.chunks_exact(row_bytes as usize);
    let texels =
        rows.flat_map(|row| row[..(size.width * texel_bytes) as usize].chunks_exact(texel_bytes as usize));
    Ok(if half {
        texels.map(|texel| bytemuck::pod_read_unaligned::<[f16; 4]>(texel).map(f16::to_f32)).collect()
    } else {
        texels.map(bytemuck::pod_read_unaligned).collect()
    })
}

/// Bytes of a picture. The product of two sides fits. Multiplied by the bytes of a pixel, it may not.
fn bytes_of(size: [u32; 2], pixel_bytes: u64) -> Result<u64, EngineError> {
    let bytes = (u64::from(size[0]) * u64::from(size[1])).saturating_mul(pixel_bytes);
    if bytes == 0 {
        return Err(EngineError::Unsupported(format!("a picture of {}×{} pixels", size[0], size[1])));
    }
    Ok(bytes)
}

fn too_large(size: [u32; 2], requested: u64, limit: u64, unit: &'static str) -> EngineError {
    EngineError::TooLarge {
        what: format!("a picture of {}×{} pixels", size[0], size[1]),
        requested,
        limit,
        unit,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_cut_off_tells_how_far_rays_came() {
        let drawn = [0.9, 0.2, 0.1, 0.9];
        let unfinished = |sample| [sample, 1.0, 0.0, -1.0];
        let at_end = |sample| [sample, 0.0, 0.0, -1.0];
        for (pixels, found) in [
            (vec![drawn, [0.0; 4]], None),
            (vec![drawn, at_end(3.0), unfinished(80.0), unfinished(70.0)], Some((3, 70))),
            (vec![at_end(3.0), at_end(9.0)], Some((2, 9))),
            (vec![unfinished(0.0)], Some((1, 0))),
        ] {
            assert_eq!(CutOff::of(&pixels).map(|c| (c.pixels, c.sample)), found, "{pixels:?}");
        }
    }
}
