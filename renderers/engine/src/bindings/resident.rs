//! What bindings of a shader hold on the device: made of what is supplied, and written over by other inputs.

use cvr_core::render::Contents;
use cvr_core::shader::{Binding, BindingKind, UniformMember};
use wgpu::util::DeviceExt as _;

use super::{Parts, Supplies};
use crate::{Device, EngineError};

/// The content of one binding on the device.
#[derive(Debug)]
pub(super) enum Resident {
    Buffer(wgpu::Buffer),
    Table(wgpu::Texture, wgpu::TextureView),
    Texture(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

impl Resident {
    pub(super) fn as_binding(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Table(_, view) | Self::Texture(view) => wgpu::BindingResource::TextureView(view),
            Self::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
        }
    }
}

/// What a binding is to hold: uploaded, or there already. Call it inside of a guard.
pub(super) fn resident(
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
            // An empty buffer cannot be bound, so it is bound as one zero word.
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
        // Clamped to the edge, like the manual filter. A ring continues from its last layer to the first.
        BindingKind::VolumeSampler => sampler(device, wgpu::AddressMode::ClampToEdge),
        BindingKind::RingSampler => sampler(device, wgpu::AddressMode::Repeat),
    })
}

/// Overwrites the contents of a binding. If their size differs, returns a new resident instead.
/// Call it inside of a guard.
pub(super) fn rewritten(
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
            // A variable that is not among the inputs is a buffer of the engine.
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

/// The content of a variable. It must not be empty.
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

/// Words `first..first + words`. An empty buffer has one part, with no words or with one zero word.
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
