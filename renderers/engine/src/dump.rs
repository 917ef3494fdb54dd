//! Every voxel of a frame, through a shader: what parity tests compare.

use cvr_core::codec::{Decoder, VoxelDump};
use cvr_core::render::Template;
use cvr_core::shader::{BindingKind, GeneratedShader, Request, generate};
use cvr_core::volume::{Extent, FrameIndex, Level};

use crate::bindings::{Bound, Parts, Supplies};
use crate::{Device, DrawSource, EngineError, VolumeTexture};

/// Invocations of one workgroup of a dump template, along x.
const WORKGROUP: u64 = 64;

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
    /// All samples of a frame (x fastest, channels interleaved, data units), fetched by `template`: a compute
    /// shader `dump` of 64 invocations along x, whose dispatch overflows into y, and which checks bounds.
    ///
    /// # Errors
    /// [`EngineError::TooLarge`] when the frame exceeds one storage binding, else as [`crate::Drawing::new`].
    pub fn dump_source(&self, source: &DrawSource<'_>, template: Template) -> Result<Vec<f32>, EngineError> {
        let voxels = source.voxels()?;
        let shader = generate(&Request {
            templates: &[template],
            entry: "dump",
            bindings: &[BindingKind::Dump],
            layout: voxels.layout,
            source: voxels.source.clone(),
            filter: None,
            limits: self.binding_limits(),
        })?;
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
        let samples = extent.voxels() * u64::from(channels);
        let (bytes, limit) = (samples * 4, self.capabilities().storage_bytes());
        if bytes > limit {
            let what = format!("a dump of {samples} samples");
            return Err(EngineError::TooLarge { what, requested: bytes, limit, unit: "bytes in one buffer" });
        }
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let output = self.guarded("making a dump", || self.empty_buffer("dump", usage, bytes))?;
        let supplies = Supplies { output: Some(&output), ..supplies };
        let bound = Bound::new(self, shader, &supplies, &mut Parts::new())?;
        self.guarded("dumping voxels", || {
            let mut encoder = self.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            bound.dispatch(&mut pass, dump_workgroups(extent.voxels()));
            drop(pass);
            self.queue().submit([encoder.finish()]);
            Ok(())
        })?;
        self.read_buffer(&output, bytes)
    }
}

/// Workgroups for this many invocations: along x as far as every device allows, then along y.
fn dump_workgroups(invocations: u64) -> [u32; 3] {
    const ALONG_X: u64 = 65535;
    let groups = invocations.div_ceil(WORKGROUP);
    [groups.min(ALONG_X) as u32, groups.div_ceil(ALONG_X) as u32, 1]
}

#[cfg(test)]
mod tests;
