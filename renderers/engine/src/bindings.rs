//! From the bindings that a generated shader lists to a pipeline with everything bound.

use std::collections::BTreeMap;

use cvr_core::codec::Resource;
use cvr_core::render::{Input, TransferFunction};
use cvr_core::shader::{Binding, BindingKind, GeneratedShader};
use wgpu::util::DeviceExt as _;

use crate::{Device, EngineError, VolumeTexture};

/// What the bindings of a shader may hold. What the shader does not list need not be there.
#[derive(Default)]
pub(crate) struct Supplies<'a> {
    /// Uniforms and tables of the renderer.
    pub(crate) inputs: &'a [Input],
    /// The uniform `slab`.
    pub(crate) slab: Option<&'a wgpu::Buffer>,
    /// The uniform `dumped`.
    pub(crate) dumped: Option<&'a wgpu::Buffer>,
    /// `image`, `dump_values` or `texels`: what the shader writes.
    pub(crate) output: Option<&'a wgpu::Buffer>,
    /// The uniform `pieces`, and `progress`.
    pub(crate) pieces: Option<[&'a wgpu::Buffer; 2]>,
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

/// A compiled shader, and everything that it lists bound.
#[derive(Debug)]
pub(crate) struct Bindings {
    pub(crate) module: wgpu::ShaderModule,
    pub(crate) layout: wgpu::PipelineLayout,
    pub(crate) groups: Vec<(u32, wgpu::BindGroup)>,
}

impl Bindings {
    /// Compiles `shader`, uploads what it reads, and binds everything for a stage of a pipeline.
    pub(crate) fn new(
        device: &Device,
        shader: &GeneratedShader,
        stage: wgpu::ShaderStages,
        supplies: &Supplies<'_>,
        parts: &mut Parts,
    ) -> Result<Self, EngineError> {
        let module = device.guarded("compiling a shader", || {
            let source = wgpu::ShaderSource::Wgsl(shader.wgsl.as_str().into());
            let label = Some(shader.entry.as_str());
            Ok(device.wgpu().create_shader_module(wgpu::ShaderModuleDescriptor { label, source }))
        })?;
        let resident: Vec<_> = device.guarded("uploading what a shader reads", || {
            shader.bindings.iter().map(|binding| resident(device, binding, supplies, parts)).collect()
        })?;
        device.guarded("binding what a shader reads", || {
            Ok(Self::assemble(device, shader, stage, module, &resident))
        })
    }

    fn assemble(
        device: &Device,
        shader: &GeneratedShader,
        stage: wgpu::ShaderStages,
        module: wgpu::ShaderModule,
        resident: &[Resident],
    ) -> Self {
        let bound = || shader.bindings.iter().zip(resident);
        let last = shader.bindings.iter().map(|binding| binding.group).max();
        let numbers = || 0..last.map_or(0, |last| last + 1);
        let layouts: Vec<_> = numbers()
            .map(|group| {
                let of_group = bound().filter(|(binding, _)| binding.group == group);
                let entries: Vec<_> = of_group.map(|(binding, _)| layout_entry(binding, stage)).collect();
                device.wgpu().create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: None,
                    entries: &entries,
                })
            })
            .collect();
        let groups = numbers()
            .zip(&layouts)
            .map(|(group, layout)| {
                let of_group = bound().filter(|(binding, _)| binding.group == group);
                let entries: Vec<_> = of_group
                    .map(|(binding, resident)| wgpu::BindGroupEntry {
                        binding: binding.binding,
                        resource: resident.as_binding(),
                    })
                    .collect();
                let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
                (group, device.wgpu().create_bind_group(&descriptor))
            })
            .collect();
        let layouts: Vec<_> = layouts.iter().map(Some).collect();
        let layout = device.wgpu().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        Self { module, layout, groups }
    }
}

/// A compute pipeline and what is bound to it.
#[derive(Debug)]
pub(crate) struct Bound {
    pipeline: wgpu::ComputePipeline,
    groups: Vec<(u32, wgpu::BindGroup)>,
}

impl Bound {
    /// Compiles `shader`, uploads what it reads, and binds everything.
    pub(crate) fn new(
        device: &Device,
        shader: &GeneratedShader,
        supplies: &Supplies<'_>,
        parts: &mut Parts,
    ) -> Result<Self, EngineError> {
        let bindings = Bindings::new(device, shader, wgpu::ShaderStages::COMPUTE, supplies, parts)?;
        let pipeline = device.guarded("building a pipeline", || {
            Ok(device.wgpu().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&shader.entry),
                layout: Some(&bindings.layout),
                module: &bindings.module,
                entry_point: Some(&shader.entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            }))
        })?;
        Ok(Self { pipeline, groups: bindings.groups })
    }

    /// Records the dispatch.
    pub(crate) fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, [x, y, z]: [u32; 3]) {
        pass.set_pipeline(&self.pipeline);
        for (group, bound) in &self.groups {
            pass.set_bind_group(*group, bound, &[]);
        }
        pass.dispatch_workgroups(x, y, z);
    }
}

/// What one binding holds on the device.
enum Resident {
    Buffer(wgpu::Buffer),
    Texture(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

impl Resident {
    fn as_binding(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Texture(view) => wgpu::BindingResource::TextureView(view),
            Self::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
        }
    }
}

fn resident(
    device: &Device,
    binding: &Binding,
    supplies: &Supplies<'_>,
    parts: &mut Parts,
) -> Result<Resident, EngineError> {
    let storage = wgpu::BufferUsages::STORAGE;
    Ok(match &binding.kind {
        BindingKind::View
        | BindingKind::Clip
        | BindingKind::Lighting
        | BindingKind::Slabs
        | BindingKind::Colour
        | BindingKind::OpacityTable
        | BindingKind::Macrocells => {
            let input = input_of(&binding.kind, supplies.inputs)?;
            let usage = if binding.kind.is_uniform() { wgpu::BufferUsages::UNIFORM } else { storage };
            // Structs end on a multiple of 16 bytes.
            let mut contents = input.contents.clone();
            contents.resize(contents.len().next_multiple_of(16), 0);
            Resident::Buffer(device.filled_buffer("input", usage, &contents)?)
        }
        BindingKind::TransferSegments(_) => return Err(missing("a search, which binds nothing")),
        BindingKind::TransferTable => {
            let input = input_of(&binding.kind, supplies.inputs)?;
            Resident::Texture(table(device, &input.contents))
        }
        BindingKind::Slab(_) => Resident::Buffer(supplies.slab.ok_or_else(|| missing("`slab`"))?.clone()),
        BindingKind::Dumped => {
            Resident::Buffer(supplies.dumped.ok_or_else(|| missing("which voxels to dump"))?.clone())
        }
        BindingKind::Image | BindingKind::Dump | BindingKind::Texels(_) => {
            Resident::Buffer(supplies.output.ok_or_else(|| missing("an output"))?.clone())
        }
        BindingKind::Pieces | BindingKind::Progress => {
            let [uniform, progress] = supplies.pieces.ok_or_else(|| missing("how far rays have come"))?;
            let bound = if binding.kind == BindingKind::Pieces { uniform } else { progress };
            Resident::Buffer(bound.clone())
        }
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
        BindingKind::VolumeSampler | BindingKind::RingSampler => {
            // Clamped to the edge, as the manual filter does; a ring goes around from its last layer to the first.
            let around = match binding.kind {
                BindingKind::RingSampler => wgpu::AddressMode::Repeat,
                _ => wgpu::AddressMode::ClampToEdge,
            };
            Resident::Sampler(device.wgpu().create_sampler(&wgpu::SamplerDescriptor {
                label: Some("volume"),
                address_mode_u: wgpu::AddressMode::ClampToEdge,
                address_mode_v: wgpu::AddressMode::ClampToEdge,
                address_mode_w: around,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }))
        }
    })
}

fn missing(what: &str) -> EngineError {
    EngineError::Unsupported(format!("the shader reads {what}, which the plan lacks"))
}

/// What the plan holds of a kind; not nothing.
fn input_of<'a>(kind: &BindingKind, inputs: &'a [Input]) -> Result<&'a Input, EngineError> {
    let input = inputs.iter().find(|input| input.kind == *kind);
    input.filter(|input| !input.contents.is_empty()).ok_or_else(|| missing(&format!("{kind:?}")))
}

/// The table of a transfer function.
fn table(device: &Device, contents: &[u8]) -> wgpu::TextureView {
    let format = wgpu::TextureFormat::Rgba32Float;
    let height = TransferFunction::TABLE_ROWS as u32;
    let width = contents.len() as u32 / (height * size_of::<[f32; 4]>() as u32);
    let descriptor = wgpu::TextureDescriptor {
        label: Some("transfer function"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = device.wgpu().create_texture_with_data(device.queue(), &descriptor, order, contents);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Words `first..first + words`; an empty buffer has one part, of no words or of the one zero word.
fn part_of(all: &[u32], first: u64, words: u64) -> Option<&[u32]> {
    if all.is_empty() {
        return (first == 0 && words <= 1).then_some(all);
    }
    let first = usize::try_from(first).ok()?;
    all.get(first..first.checked_add(usize::try_from(words).ok()?)?)
}

fn layout_entry(binding: &Binding, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let ty = match binding.kind {
        ref kind if kind.is_uniform() => buffer(wgpu::BufferBindingType::Uniform),
        BindingKind::Scratch { written, .. } => {
            buffer(wgpu::BufferBindingType::Storage { read_only: !written })
        }
        BindingKind::Image | BindingKind::Progress | BindingKind::Dump | BindingKind::Texels(_) => {
            buffer(wgpu::BufferBindingType::Storage { read_only: false })
        }
        BindingKind::TransferTable => wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        BindingKind::VolumeTexture { filterable } => wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension: wgpu::TextureViewDimension::D3,
            multisampled: false,
        },
        BindingKind::VolumeSampler | BindingKind::RingSampler => {
            wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)
        }
        _ => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
    };
    wgpu::BindGroupLayoutEntry { binding: binding.binding, visibility, ty, count: None }
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
}
