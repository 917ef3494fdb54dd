//! A codec's passes that rebuild a frame, bound to their buffers.

use cvr_core::shader::{BindingKind, DeferredShaders, PassShader};

use crate::bindings::{Bound, Parts, Supplies, check_workgroups};
use crate::pipelines::Target;
use crate::{Device, EngineError};

/// Passes that can be dispatched any number of times. The scratch buffers live as long as this object.
#[derive(Debug)]
pub(crate) struct BoundPasses {
    passes: Vec<(Bound, [u32; 3])>,
    scratch_bytes: u64,
}

/// The parts of all scratch buffers that a shader uses.
pub(crate) fn scratch_buffers(device: &Device, shaders: &DeferredShaders<'_>) -> Result<Parts, EngineError> {
    let all = shaders.passes.iter().map(|pass| &pass.shader).chain([&shaders.pack]);
    device.guarded("making scratch buffers", || {
        let mut parts = Parts::new();
        for binding in all.flat_map(|shader| &shader.bindings) {
            if let BindingKind::Scratch { buffer, first, words, .. } = binding.kind
                && !parts.contains_key(&(buffer, first))
            {
                let part = device.empty_buffer("scratch", wgpu::BufferUsages::STORAGE, words * 4)?;
                parts.insert((buffer, first), part);
            }
        }
        Ok(parts)
    })
}

impl BoundPasses {
    /// Compiles the passes, and uploads their data into `parts`.
    pub(crate) fn new(
        device: &Device,
        passes: &[PassShader],
        supplies: &Supplies<'_>,
        parts: &mut Parts,
    ) -> Result<Self, EngineError> {
        let bind = |PassShader { shader, workgroups }: &PassShader| {
            check_workgroups(device, &format!("pass `{}`", shader.entry), *workgroups)?;
            Ok((Bound::new(device, shader, Target::Compute, supplies, parts)?, *workgroups))
        };
        let passes = passes.iter().map(bind).collect::<Result<_, EngineError>>()?;
        let scratch_bytes = supplies.scratch.map_or(0, |all| all.values().map(wgpu::Buffer::size).sum());
        Ok(Self { passes, scratch_bytes })
    }

    pub(crate) const fn len(&self) -> usize {
        self.passes.len()
    }

    pub(crate) const fn scratch_bytes(&self) -> u64 {
        self.scratch_bytes
    }

    /// Records pass `index`.
    pub(crate) fn dispatch(&self, index: usize, pass: &mut wgpu::ComputePass<'_>) {
        let (bound, workgroups) = &self.passes[index];
        bound.dispatch(pass, *workgroups);
    }
}
