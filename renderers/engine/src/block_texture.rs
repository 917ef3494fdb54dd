//! A frame in a 3-D texture, stored as the codec's own blocks. The texture unit decodes them.

use cvr_core::codec::{BlockFormat, BlockTexture, DecodedForm, TexelFormat};
use cvr_core::shader::{TextureSampling, generate_decode, voxels_per_invocation};
use cvr_core::volume::{Axis, Extent, VolumeLayout};

use crate::bindings::{Bound, Parts, Supplies};
use crate::pipelines::Target;
use crate::slabs::{Slab, Slabs, WORKGROUP, no_slab, slab_uniform};
use crate::upload::SLAB_BYTES;
use crate::{Device, EngineError, TextureChoice, VolumeTexture};

const fn texture_format(format: BlockFormat) -> wgpu::TextureFormat {
    match format {
        BlockFormat::Bc4 => wgpu::TextureFormat::Bc4RUnorm,
    }
}

impl VolumeTexture {
    /// Uploads one frame as blocks. The texture unit decodes them when it reads a texel. Only the blocks are resident.
    ///
    /// # Errors
    /// [`EngineError::Unsupported`] if [`crate::Capabilities::blocks`] gives a reason, or the number of words does not
    /// match the layout; [`EngineError::TooLarge`] if an axis exceeds the device's textures; and errors of the driver.
    pub fn upload_blocks(
        device: &Device,
        layout: &VolumeLayout,
        blocks: &BlockTexture<'_>,
    ) -> Result<Self, EngineError> {
        let &BlockTexture { format, scale, offset, .. } = blocks;
        let capabilities = device.capabilities();
        capabilities.blocks(format, layout.channels).map_err(|e| EngineError::Unsupported(e.to_string()))?;
        let [width, height, depth] = format.padded(layout.extent);
        let padded =
            Extent::new(width, height, depth).map_err(|e| EngineError::Unsupported(e.to_string()))?;
        capabilities.check_edges(padded)?;
        let bytes: &[u8] = bytemuck::cast_slice(&blocks.words);
        let wanted = format.bytes(layout.extent);
        if bytes.len() as u64 != wanted {
            let text = format!("{} bytes of blocks for a frame of {wanted}", bytes.len());
            return Err(EngineError::Unsupported(text));
        }
        // Block texels read as fractions of a range, like 8-bit texels.
        let form = DecodedForm { format: TexelFormat::Unorm8, scale, offset };
        let choice = TextureChoice { form, sampling: TextureSampling::Hardware, fallback: None };
        let texture = Self::of_format(device, layout, choice, (texture_format(format), Some(format)))?;
        let row_bytes = width / format.edge() * format.words() * 4;
        let rows = height / format.edge();
        let slice_bytes = row_bytes as usize * rows as usize;
        let slices = (SLAB_BYTES / slice_bytes).max(1);
        device.guarded("uploading blocks of a volume", || {
            for (slab, first) in bytes.chunks(slices * slice_bytes).zip((0_u32..).step_by(slices)) {
                let layout = wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row_bytes),
                    rows_per_image: Some(rows),
                };
                let depth_or_array_layers = (slab.len() / slice_bytes) as u32;
                let size = wgpu::Extent3d { width, height, depth_or_array_layers };
                device.queue().write_texture(texture.place(0, first), slab, layout, size);
                device.flush(bytes.len() > slab.len())?;
            }
            Ok(())
        })?;
        Ok(texture)
    }

    /// All samples as a shader loads them, through the packing pass of the site *deferred*.
    pub(crate) fn load(&self, device: &Device) -> Result<Vec<f32>, EngineError> {
        let layout = self.layout();
        let (form, limits) = (DecodedForm::FLOAT32, device.binding_limits());
        let source = self.source();
        let shader = generate_decode(&source, layout, (form.format, Axis::Z), limits)?;
        let most_bytes = (limits.storage_words * 4).min(SLAB_BYTES as u64);
        let width = layout.extent.x();
        let slabs = Slabs::new(layout.extent, form.format.bytes(), most_bytes)?;
        let texels = device.guarded("preparing to load texels", || {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
            device.empty_buffer("texels", usage, slabs.most_bytes())
        })?;
        let supplies = Supplies {
            inputs: &[no_slab()],
            storage: &[("texels", &texels)],
            texture: Some(self),
            ..Supplies::default()
        };
        let bound = Bound::new(device, &shader, Target::Compute, &supplies, &mut Parts::new())?;
        let along = width.div_ceil(voxels_per_invocation(form.format, layout.channels) * WORKGROUP);
        let mut all = Vec::with_capacity(layout.samples_per_frame() as usize);
        for slab in slabs.iter() {
            let Slab { rows, slices, .. } = slab;
            device.guarded("loading texels", || {
                bound.write_uniform(device, "slab", &slab_uniform(slab, slabs, form, width));
                let mut encoder =
                    device.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                bound.dispatch(&mut pass, [along, rows, slices]);
                drop(pass);
                device.queue().submit([encoder.finish()]);
                Ok(())
            })?;
            let values: Vec<f32> = device.read_buffer(&texels, slabs.bytes(slab))?;
            all.extend(values.chunks_exact(slabs.row_bytes() / 4).flat_map(|row| &row[..width as usize]));
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests;
