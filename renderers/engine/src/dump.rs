//! Every voxel of a frame, through a shader: what parity tests compare.

use cvr_core::codec::Decoder;
use cvr_core::render::Template;
use cvr_core::shader::{BindingKind, GeneratedShader, Request, generate};
use cvr_core::volume::{FrameIndex, Level};

use crate::bindings::{Bound, Parts, Supplies};
use crate::{Device, DrawSource, EngineError};

/// Invocations of one workgroup of a dump template, along x.
const WORKGROUP: u64 = 64;

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
        self.run_dump(&shader, supplies, voxels.layout.samples_per_frame())
    }

    /// Runs a dump shader that writes `samples` samples.
    pub(crate) fn run_dump(
        &self,
        shader: &GeneratedShader,
        supplies: Supplies<'_>,
        samples: u64,
    ) -> Result<Vec<f32>, EngineError> {
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
            bound.dispatch(&mut pass, dump_workgroups(samples));
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
mod tests {
    use super::*;

    #[test]
    fn a_dispatch_covers_every_sample_within_the_limits() {
        for samples in [1, 64, 65, 65535 * 64, 65535 * 64 + 1, 256 * 256 * 256, 1 << 28] {
            let [x, y, z] = dump_workgroups(samples);
            assert!(u64::from(x) * u64::from(y) * u64::from(z) * WORKGROUP >= samples);
            assert!(x <= 65535 && y <= 65535);
        }
        assert_eq!(dump_workgroups(1), [1, 1, 1]);
    }
}
