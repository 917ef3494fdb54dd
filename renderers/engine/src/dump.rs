//! Decodes every voxel of a frame with a shader, for parity tests.

use cvr_core::codec::{Decoder, VoxelDump};
use cvr_core::render::{Contents, Template};
use cvr_core::shader::{GeneratedShader, Program};
use cvr_core::volume::{Extent, FrameIndex, Level};

use crate::bindings::{Bound, Parts, Supplies};
use crate::pipelines::Target;
use crate::{Device, DrawSource, EngineError, VolumeTexture};

/// Invocations of one workgroup of a dump template, along x.
const WORKGROUP: u64 = 64;
/// Most bytes of a dump on the device at a time.
const PIECE_BYTES: u64 = 64 << 20;

impl VoxelDump for Device {
    fn dump_at(
        &self,
        codec: &str,
        decoder: &dyn Decoder,
        (frame, level): (FrameIndex, Level),
        use_cell: bool,
    ) -> Result<Vec<f32>, String> {
        let source = DrawSource::Inline { codec, decoder, frame, level };
        let template = if use_cell { cvr_shaders::DUMP_CELL } else { cvr_shaders::DUMP };
        self.dump_source(&source, template).map_err(|e| e.to_string())
    }

    fn dump_frame(
        &self,
        codec: &str,
        decoder: &dyn Decoder,
        (frame, level): (FrameIndex, Level),
    ) -> Result<Vec<f32>, String> {
        let decoded = VolumeTexture::decode(self, codec, decoder, frame, level);
        decoded.and_then(|(texture, _)| texture.read(self)).map_err(|e| e.to_string())
    }
}

impl Device {
    /// All samples of a frame (x fastest, channels interleaved, data units), fetched by `template`. It is a compute
    /// shader `dump` of 64 invocations along x. Its dispatch continues along y, and it must check bounds.
    ///
    /// # Errors
    /// [`EngineError::TooLarge`] if the frame has more voxels than 32 bits can count, else as [`crate::Drawing::new`].
    pub fn dump_source(&self, source: &DrawSource<'_>, template: Template) -> Result<Vec<f32>, EngineError> {
        let voxels = source.voxels()?;
        let shader = voxels.shader(self, &Program::dump(template), None)?;
        let supplies = Supplies { buffers: &voxels.buffers, texture: voxels.texture, ..Supplies::default() };
        self.run_dump(&shader, supplies, voxels.layout.extent, voxels.layout.channels)
    }

    /// Runs a dump shader, one invocation per voxel.
    pub(crate) fn run_dump(
        &self,
        shader: &GeneratedShader,
        supplies: Supplies<'_>,
        extent: Extent,
        channels: u32,
    ) -> Result<Vec<f32>, EngineError> {
        let most_bytes = self.capabilities().storage_bytes().min(PIECE_BYTES);
        self.run_dump_in_pieces(shader, supplies, (extent, channels), most_bytes)
    }

    /// The same, with at most `bytes` bytes on the device at a time.
    fn run_dump_in_pieces(
        &self,
        shader: &GeneratedShader,
        supplies: Supplies<'_>,
        (extent, channels): (Extent, u32),
        most_bytes: u64,
    ) -> Result<Vec<f32>, EngineError> {
        let voxels = extent.voxels();
        let numbers = u64::from(u32::MAX);
        if voxels > numbers {
            let what = format!("a dump of {}×{}×{} voxels", extent.x(), extent.y(), extent.z());
            return Err(EngineError::TooLarge { what, requested: voxels, limit: numbers, unit: "voxels" });
        }
        let voxel_bytes = 4 * u64::from(channels);
        let piece = (most_bytes / voxel_bytes).clamp(1, voxels);
        let output = self.guarded("making a dump", || {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
            self.empty_buffer("dump", usage, piece * voxel_bytes)
        })?;
        let range = |first: u64, end: u64| bytemuck::cast_slice(&[first as u32, end as u32]).to_vec();
        let inputs = [Contents { name: "dumped", bytes: range(0, 0) }];
        let supplies = Supplies { inputs: &inputs, storage: &[("dump_values", &output)], ..supplies };
        let bound = Bound::new(self, shader, Target::Compute, &supplies, &mut Parts::new())?;
        let mut values = Vec::with_capacity((voxels * u64::from(channels)) as usize);
        for first in (0..voxels).step_by(piece as usize) {
            let end = voxels.min(first + piece);
            self.guarded("dumping voxels", || {
                bound.write_uniform(self, "dumped", &range(first, end));
                let mut encoder =
                    self.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                bound.dispatch(&mut pass, dump_workgroups(end - first));
                drop(pass);
                self.queue().submit([encoder.finish()]);
                Ok(())
            })?;
            values.extend(self.read_buffer::<f32>(&output, (end - first) * voxel_bytes)?);
        }
        Ok(values)
    }
}

/// Workgroups for this many invocations: along x up to the limit that every device allows, then along y.
fn dump_workgroups(invocations: u64) -> [u32; 3] {
    const ALONG_X: u64 = 65535;
    let groups = invocations.div_ceil(WORKGROUP);
    [groups.min(ALONG_X) as u32, groups.div_ceil(ALONG_X) as u32, 1]
}

#[cfg(test)]
mod tests;
