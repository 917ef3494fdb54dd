//! A pipeline with everything that its shader lists bound.

mod resident;

use std::collections::BTreeMap;
use std::sync::Arc;

use cvr_core::codec::Resource;
use cvr_core::render::Contents;
use cvr_core::shader::{Binding, BindingKind, GeneratedShader};

use resident::{Resident, resident, rewritten};

use crate::pipelines::{Compiled, Executable, Target};
use crate::{Device, EngineError, VolumeTexture};

/// Contents for the bindings of a shader. Unused ones may be missing.
#[derive(Copy, Clone, Default)]
pub(crate) struct Supplies<'a> {
    /// Contents of variables.
    pub(crate) inputs: &'a [Contents],
    /// Existing storage buffers, by the names of their variables.
    pub(crate) storage: &'a [(&'static str, &'a wgpu::Buffer)],
    /// The codec's buffers.
    pub(crate) buffers: &'a [Resource<'a>],
    /// Scratch buffers of the codec's passes.
    pub(crate) scratch: Option<&'a Parts>,
    /// The decoded volume.
    pub(crate) texture: Option<&'a VolumeTexture>,
}

/// Parts of the codec's buffers, or of its scratch buffers, on the device: `(buffer, first word)` → part. Passes share
/// them.
pub(crate) type Parts = BTreeMap<(usize, u64), wgpu::Buffer>;

/// A pipeline and its bindings.
#[derive(Debug)]
pub(crate) struct Bound {
    compiled: Arc<Compiled>,
    /// The content of each binding of the shader.
    residents: Vec<Resident>,
    groups: Vec<wgpu::BindGroup>,
}

impl Bound {
    /// Compiles `shader` unless it is kept, uploads its data, and binds everything.
    pub(crate) fn new(
        device: &Device,
        shader: &GeneratedShader,
        target: Target,
        supplies: &Supplies<'_>,
        parts: &mut Parts,
    ) -> Result<Self, EngineError> {
        let compiled = device.compiled(shader, target)?;
        let residents: Vec<_> = device.guarded("uploading what a shader reads", || {
            compiled.bindings.iter().map(|binding| resident(device, binding, supplies, parts)).collect()
        })?;
        let groups =
            device.guarded("binding what a shader reads", || Ok(groups(device, &compiled, &residents)))?;
        Ok(Self { compiled, residents, groups })
    }

    /// Uploads new contents of variables.
    pub(crate) fn set_inputs(&mut self, device: &Device, inputs: &[Contents]) -> Result<(), EngineError> {
        let Self { compiled, residents, groups: bound } = self;
        device.guarded("uploading what a shader reads", || {
            let mut moved = false;
            for (binding, resident) in compiled.bindings.iter().zip(residents.iter_mut()) {
                if let Some(other) = rewritten(device, binding, resident, inputs)? {
                    *resident = other;
                    moved = true;
                }
            }
            if moved {
                *bound = groups(device, compiled, residents);
            }
            Ok(())
        })
    }

    /// Writes one uniform, if the shader has it. Call it inside a guard.
    pub(crate) fn write_uniform(&self, device: &Device, name: &str, bytes: &[u8]) {
        for (binding, resident) in self.compiled.bindings.iter().zip(&self.residents) {
            if let (BindingKind::Uniforms(members), Resident::Buffer(buffer)) = (&binding.kind, resident) {
                for member in members.iter().filter(|member| member.name == name) {
                    device.queue().write_buffer(buffer, u64::from(member.offset), bytes);
                }
            }
        }
    }

    /// The buffer of all uniforms.
    pub(crate) fn uniforms(&self) -> Option<&wgpu::Buffer> {
        self.compiled.bindings.iter().zip(&self.residents).find_map(|pair| match pair {
            (Binding { kind: BindingKind::Uniforms(_), .. }, Resident::Buffer(buffer)) => Some(buffer),
            _ => None,
        })
    }

    /// Records the dispatch.
    pub(crate) fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, [x, y, z]: [u32; 3]) {
        let Executable::Compute(pipeline) = &self.compiled.pipeline else { return };
        pass.set_pipeline(pipeline);
        for (group, bound) in (0..).zip(&self.groups) {
            pass.set_bind_group(group, bound, &[]);
        }
        pass.dispatch_workgroups(x, y, z);
    }

    /// Makes a pass ready for triangles.
    pub(crate) fn set(&self, pass: &mut wgpu::RenderPass<'_>) {
        let Executable::Blend(pipeline) = &self.compiled.pipeline else { return };
        pass.set_pipeline(pipeline);
        for (group, bound) in (0..).zip(&self.groups) {
            pass.set_bind_group(group, bound, &[]);
        }
    }
}

/// Fails if a device cannot dispatch this many workgroups.
pub(crate) fn check_workgroups(device: &Device, what: &str, workgroups: [u32; 3]) -> Result<(), EngineError> {
    let most = workgroups.into_iter().max().unwrap_or(0);
    let limit = device.capabilities().workgroups_per_axis;
    if most > limit {
        let (what, requested, limit) = (what.to_owned(), u64::from(most), u64::from(limit));
        return Err(EngineError::TooLarge { what, requested, limit, unit: "workgroups along one axis" });
    }
    Ok(())
}

fn groups(device: &Device, compiled: &Compiled, residents: &[Resident]) -> Vec<wgpu::BindGroup> {
    let group = |(group, layout): (u32, &wgpu::BindGroupLayout)| {
        let of_group = compiled.bindings.iter().zip(residents).filter(|(binding, _)| binding.group == group);
        let entries: Vec<_> = of_group
            .map(|(binding, resident)| wgpu::BindGroupEntry {
                binding: binding.binding,
                resource: resident.as_binding(),
            })
            .collect();
        device.wgpu().create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    };
    (0..).zip(&compiled.layouts).map(group).collect()
}
