//! A pipeline with everything that its shader lists bound.

use std::collections::BTreeMap;
use std::sync::Arc;

use cvr_core::codec::Resource;
use cvr_core::render::Contents;
use cvr_core::shader::{Binding, BindingKind, GeneratedShader, UniformMember};
use wgpu::util::DeviceExt as _;

use crate::pipelines::{Compiled, Executable, Target};
use crate::{Device, EngineError, VolumeTexture};

/// What the bindings of a shader may hold. What the shader does not list need not be there.
#[derive(Copy, Clone, Default)]
pub(crate) struct Supplies<'a> {
    /// Contents of variables.
    pub(crate) inputs: &'a [Contents],
    /// Storage buffers that are there already, by the names of their variables.
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

/// A pipeline and what is bound to it.
#[derive(Debug)]
pub(crate) struct Bound {
    compiled: Arc<Compiled>,
    /// What each binding of the shader holds.
    residents: Vec<Resident>,
    groups: Vec<wgpu::BindGroup>,
}

/// What one binding holds on the device.
#[derive(Debug)]
enum Resident {
    Buffer(wgpu::Buffer),
    Table(wgpu::Texture, wgpu::TextureView),
    Texture(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

impl Resident {
    fn as_binding(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Table(_, view) | Self::Texture(view) => wgpu::BindingResource::TextureView(view),
            Self::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
        }
    }
}

impl Bound {
    /// Compiles `shader`, unless that has been done before, uploads what it reads, and binds everything.
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

    /// Uploads other contents of variables.
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

    /// Writes one uniform, if the shader has it. Call it inside of a guard.
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

/// Fails where a device does not dispatch so many workgroups.
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

fn resident(
    device: &Device,
    binding: &Binding,
    supplies: &Supplies<'_>,
    parts: &mut Parts,
) -> Result<Resident, EngineError> {
    let storage = wgpu::BufferUsages::STORAGE;
    Ok(match &binding.kind {
        BindingKind::Uniforms(members) => {
            let bytes = uniforms(members, supplies.inputs)?;
            Resident::Buffer(device.filled_buffer("inputs", wgpu::BufferUsages::UNIFORM, &bytes)?)
        }
        BindingKind::Storage { name, .. } => {
            if let Some((_, buffer)) = supplies.storage.iter().find(|(owned, _)| owned == name) {
                return Ok(Resident::Buffer((*buffer).clone()));
            }
            let contents = contents_of(name, supplies.inputs)?;
            Resident::Buffer(device.filled_buffer(name, storage, &padded(contents))?)
        }
        BindingKind::Table { name, rows } => table(device, contents_of(name, supplies.inputs)?, *rows),
        BindingKind::Words { resource, first, words } => {
            if let Some(part) = parts.get(&(*resource, *first)) {
                return Ok(Resident::Buffer(part.clone()));
            }
            let whole = supplies.buffers.get(*resource).ok_or_else(|| missing("a buffer of the codec"))?;
            let part = part_of(&whole.words, *first, *words)
                .ok_or_else(|| missing(&format!("words beyond the end of `{}`", whole.name)))?;
            // An empty buffer cannot be bound: the contract has it bound as one zero word.
            let part = if part.is_empty() { &[0] } else { part };
            let buffer = device.filled_buffer(whole.name, storage, bytemuck::cast_slice(part))?;
            parts.insert((*resource, *first), buffer.clone());
            Resident::Buffer(buffer)
        }
        BindingKind::Scratch { buffer, first, .. } => {
            let part = supplies.scratch.and_then(|parts| parts.get(&(*buffer, *first)));
            Resident::Buffer(part.ok_or_else(|| missing("a scratch buffer"))?.clone())
        }
        BindingKind::VolumeTexture { .. } => {
            Resident::Texture(supplies.texture.ok_or_else(|| missing("a texture"))?.view().clone())
        }
        // Clamped to the edge, as the manual filter does; a ring goes around from its last layer to the first.
        BindingKind::VolumeSampler => sampler(device, wgpu::AddressMode::ClampToEdge),
        BindingKind::RingSampler => sampler(device, wgpu::AddressMode::Repeat),
    })
}

/// Writes the contents of a binding over what it holds, or, where they have another size, what it is to hold instead.
fn rewritten(
    device: &Device,
    binding: &Binding,
    held: &Resident,
    inputs: &[Contents],
) -> Result<Option<Resident>, EngineError> {
    match (&binding.kind, held) {
        (BindingKind::Uniforms(members), Resident::Buffer(buffer)) => {
            device.queue().write_buffer(buffer, 0, &uniforms(members, inputs)?);
        }
        (BindingKind::Storage { name, .. }, Resident::Buffer(buffer)) => {
            // What is not among the inputs is a buffer of the engine's.
            let Some(contents) = inputs.iter().find(|contents| contents.name == *name) else {
                return Ok(None);
            };
            let bytes = padded(&contents.bytes);
            if bytes.len() as u64 != buffer.size() {
                let usage = wgpu::BufferUsages::STORAGE;
                return Ok(Some(Resident::Buffer(device.filled_buffer(name, usage, &bytes)?)));
            }
            device.queue().write_buffer(buffer, 0, &bytes);
        }
        (BindingKind::Table { name, rows }, Resident::Table(texture, _)) => {
            let contents = contents_of(name, inputs)?;
            if table_size(contents, *rows) != texture.size() {
                return Ok(Some(table(device, contents, *rows)));
            }
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(texture.width() * TEXEL_BYTES),
                rows_per_image: None,
            };
            device.queue().write_texture(texture.as_image_copy(), contents, layout, texture.size());
        }
        _ => {}
    }
    Ok(None)
}

fn missing(what: &str) -> EngineError {
    EngineError::Unsupported(format!("the shader reads {what}, which the plan lacks"))
}

/// What a variable holds; not nothing.
fn contents_of<'a>(name: &str, inputs: &'a [Contents]) -> Result<&'a [u8], EngineError> {
    let contents = inputs.iter().find(|contents| contents.name == name && !contents.bytes.is_empty());
    contents.map(|contents| &contents.bytes[..]).ok_or_else(|| missing(&format!("`{name}`")))
}

/// Structs and buffers end on a multiple of 16 bytes.
fn padded(contents: &[u8]) -> Vec<u8> {
    let mut bytes = contents.to_vec();
    bytes.resize(bytes.len().next_multiple_of(16), 0);
    bytes
}

/// The contents of all uniforms.
fn uniforms(members: &[UniformMember], inputs: &[Contents]) -> Result<Vec<u8>, EngineError> {
    let mut all = Vec::new();
    for UniformMember { name, offset, bytes } in members {
        let contents = contents_of(name, inputs)?;
        if contents.len() != *bytes as usize {
            let given = contents.len();
            let problem =
                format!("the uniform `{name}` has {given} bytes, and its struct in the shader {bytes}");
            return Err(EngineError::Unsupported(problem));
        }
        all.resize(*offset as usize, 0);
        all.extend_from_slice(contents);
    }
    Ok(padded(&all))
}

/// Bytes of a table's texel.
const TEXEL_BYTES: u32 = size_of::<[f32; 4]>() as u32;

fn table_size(contents: &[u8], rows: u32) -> wgpu::Extent3d {
    let width = contents.len() as u32 / (rows.max(1) * TEXEL_BYTES);
    wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 }
}

fn table(device: &Device, contents: &[u8], rows: u32) -> Resident {
    let descriptor = wgpu::TextureDescriptor {
        label: Some("table"),
        size: table_size(contents, rows),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = device.wgpu().create_texture_with_data(device.queue(), &descriptor, order, contents);
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    Resident::Table(texture, view)
}

fn sampler(device: &Device, along_z: wgpu::AddressMode) -> Resident {
    Resident::Sampler(device.wgpu().create_sampler(&wgpu::SamplerDescriptor {
        label: Some("volume"),
        address_mode_u: wgpu::AddressMode::ClampToEdge,
        address_mode_v: wgpu::AddressMode::ClampToEdge,
        address_mode_w: along_z,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    }))
}

/// Words `first..first + words`; an empty buffer has one part, of no words or of the one zero word.
fn part_of(all: &[u32], first: u64, words: u64) -> Option<&[u32]> {
    if all.is_empty() {
        return (first == 0 && words <= 1).then_some(all);
    }
    let first = usize::try_from(first).ok()?;
    all.get(first..first.checked_add(usize::try_from(words).ok()?)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_cut_where_the_generator_says() {
        let words = [1, 2, 3, 4, 5];
        assert_eq!(part_of(&words, 0, 5), Some(&words[..]));
        assert_eq!(part_of(&words, 2, 2), Some(&[3, 4][..]));
        assert_eq!(part_of(&words, 4, 2), None);
        assert_eq!(part_of(&words, u64::MAX, 2), None);
        assert_eq!(part_of(&[], 0, 1), Some(&[][..]));
        assert_eq!(part_of(&[], 1, 1), None);
    }

    #[test]
    fn uniforms_lie_where_the_shader_has_them() {
        let contents = |name, bytes| Contents { name, bytes: vec![7; bytes] };
        let member = |name, offset, bytes| UniformMember { name, offset, bytes };
        let members = [member("a", 0, 12), member("b", 16, 4)];
        let all = uniforms(&members, &[contents("b", 4), contents("a", 12)]).unwrap();
        assert_eq!((all.len(), all[11], all[12], all[16], all[20]), (32, 7, 0, 7, 0));
        let wrong = uniforms(&members, &[contents("a", 16), contents("b", 4)]).unwrap_err();
        assert_eq!(wrong.to_string(), "the uniform `a` has 16 bytes, and its struct in the shader 12");
        assert!(uniforms(&members, &[contents("a", 12)]).unwrap_err().to_string().contains("`b`"));
    }
}
