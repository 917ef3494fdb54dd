//! Putting the text together, and proving it.

use cvr_shaders as shaders;

use super::accessors::{self, Access, Accessors};
use super::form::MOST_INLINED_OPERATIONS;
use super::inlined;
use super::lint::{self, Role, Snippet};
use super::origin::Mapped;
use super::resolve::{Resolved, resolve};
use super::text::{self, Text};
use super::{
    Binding, BindingKind, Draft, Form, GeneratedShader, Request, ShaderError, Source, TextureSampling,
};
use crate::render::Filter;

/// Generates, parses, lints and validates a shader.
///
/// # Errors
/// When a template or snippet does not parse, the snippet breaks its contract, or the device's limits do not
/// suffice. The message points at the author's own file, line and column.
pub fn generate(request: &Request<'_>) -> Result<GeneratedShader, ShaderError> {
    let resolved = resolve(request.program, Form::Unrolled)?;
    let mut shader = assemble(request, &resolved, Form::Unrolled)?.prove(request, Form::Unrolled)?;
    for form in looped(request, &resolved) {
        if shader.inlined_operations <= MOST_INLINED_OPERATIONS {
            break;
        }
        let resolved = resolve(request.program, form)?;
        shader = assemble(request, &resolved, form)?.prove(request, form)?;
    }
    Ok(shader)
}

/// The forms that shorten the text of a request, each shorter than the one before.
fn looped(request: &Request<'_>, resolved: &Resolved) -> impl Iterator<Item = Form> {
    let lit = resolved.modules.contains(&shaders::GRADIENT.into()).then_some(Form::OneSample);
    let eight = (request.filter == Some(Filter::Linear)).then_some(Form::OneFetch);
    lit.into_iter().chain(eight)
}

/// The text that [`generate()`] validates, much cheaper than a validated shader. A cache of shaders uses it as its key.
///
/// # Errors
/// When modules clash, or the device's limits do not suffice.
pub fn draft(request: &Request<'_>) -> Result<Draft, ShaderError> {
    let Assembled { out, bindings, .. } =
        assemble(request, &resolve(request.program, Form::Unrolled)?, Form::Unrolled)?;
    Ok(Draft { wgsl: out.wgsl, bindings, entry: request.program.entry.to_owned() })
}

/// A text with its bindings.
struct Assembled<'a> {
    out: Text,
    bindings: Vec<Binding>,
    snippet: Option<Snippet<'a>>,
}

/// The shader in one of its forms.
fn assemble<'a>(
    request: &Request<'a>,
    resolved: &Resolved,
    form: Form,
) -> Result<Assembled<'a>, ShaderError> {
    let mut out = Text::default();
    out.generated("the volume", &text::volume_constants(request.layout));
    let own = match &request.source {
        Source::Buffers { modules, .. } => *modules,
        Source::Inline { .. } | Source::Frame { .. } | Source::Texture { .. } | Source::Ring { .. } => &[],
    };
    let calls = |function: &str| {
        resolved.mentions(function) || own.iter().any(|module| module.source.contains(function))
    };
    let (voxel, channels) = match request.layout.channels {
        1 => (shaders::VOXEL_SCALAR, shaders::CHANNEL_SCALAR),
        _ => (shaders::VOXEL_RGB, shaders::CHANNEL_RGB),
    };
    out.template(voxel);
    if calls("voxel_channel(") || matches!(request.source, Source::Frame { .. }) {
        out.template(channels);
    }
    let (declarations, mut bindings) = text::variables(&resolved.variables);
    out.generated("bindings of the template", &declarations);
    resolved.modules.iter().for_each(|module| out.module(module));
    filter(&mut out, request, form)?;

    let mut snippet = None;
    match &request.source {
        Source::Inline { codec, module, resources, frame, level } => {
            let by_cells = request.filter == Some(Filter::OptimisedLinear);
            let cell = by_cells || calls("voxel_cell(");
            // The other filters fetch single voxels.
            let fetch = request.filter.is_some() && !by_cells || calls("voxel_fetch(");
            let owner = format!("codec `{codec}`");
            let (accessors, parts) = accessors::resource_accessors(
                (&owner, codec),
                resources,
                request.limits,
                storage_of(&bindings),
            )?;
            bindings.extend(parts);
            let constants = text::codec_constants(codec, &module.constants)?;
            out.generated(&format!("constants of codec {codec}"), &constants);
            out.generated(&format!("buffers of codec {codec}"), &accessors);
            let level = text::level_accessors(codec, module.source, *frame, *level);
            out.generated(&format!("level of codec {codec}"), &level);
            out.generated("voxels are decoded at every fetch", &text::inline_source(codec, fetch, cell));
            out.file(module.file, module.source, true);
            snippet =
                Some(Snippet { codec, file: module.file, source: module.source, role: Role::Voxel { cell } });
        }
        Source::Frame { buffer, words } => {
            let mut frame = Accessors::new("the rebuilt frame", request.limits);
            let read = Access { read: true, write: false };
            frame.add("frame_words", "", *words, read, |first, words| BindingKind::Scratch {
                buffer: *buffer,
                first,
                words,
                written: false,
            })?;
            let (declarations, parts) = frame.finish(storage_of(&bindings))?;
            bindings.extend(parts);
            out.generated("the frame that the codec's passes have rebuilt", &declarations);
            out.template(shaders::DEFERRED_FRAME);
        }
        Source::Buffers { name, modules, constants, buffers } => {
            let owner = format!("what holds the volume (`{name}`)");
            let (accessors, parts) = accessors::resource_accessors(
                (&owner, name),
                buffers,
                request.limits,
                storage_of(&bindings),
            )?;
            bindings.extend(parts);
            out.generated(&format!("constants of {name}"), &text::codec_constants(name, constants)?);
            out.generated(&format!("buffers of {name}"), &accessors);
            modules.iter().for_each(|module| out.template(*module));
        }
        Source::Texture { form, sampling, padded } => {
            let hardware = *sampling == TextureSampling::Hardware && request.filter == Some(Filter::Linear);
            let (declarations, texture) =
                text::texture_bindings(hardware.then_some(BindingKind::VolumeSampler));
            bindings.extend(texture);
            out.generated("bindings of the decoded volume", &declarations);
            out.generated("texels of the decoded volume", &text::texel_constants(*form));
            if let Some(size) = padded.filter(|_| hardware) {
                out.generated("size of the texture", &text::texture_size(size));
            }
            // With hardware filtering, single voxels are not fetched.
            if !hardware {
                out.template(shaders::SOURCE_TEXTURE);
            }
        }
        Source::Ring { form, sampling, axis } => {
            let hardware = *sampling == TextureSampling::Hardware && request.filter == Some(Filter::Linear);
            let (declarations, texture) =
                text::texture_bindings(hardware.then_some(BindingKind::RingSampler));
            bindings.extend(texture);
            out.generated("bindings of the ring of layers", &declarations);
            out.generated("texels of the ring of layers", &text::texel_constants(*form));
            let reads = if hardware { shaders::FILTER_HARDWARE_RING } else { shaders::SOURCE_RING };
            let calls = |function: &str| calls(function) || reads.source.contains(function);
            out.generated("the ring of layers", &text::ring(*axis, calls));
            // With hardware filtering, the texture unit samples, and single voxels are not fetched.
            if !hardware {
                out.template(shaders::SOURCE_RING);
            }
        }
    }
    Ok(Assembled { out, bindings, snippet })
}

/// Storage buffers among the template's bindings.
fn storage_of(bindings: &[Binding]) -> u32 {
    bindings.iter().filter(|b| b.kind.is_storage()).count() as u32
}

/// A list of the declarations that the generator adds to a snippet.
fn provided(source: &Source<'_>) -> String {
    let Source::Inline { codec, module, resources, .. } = source else { return String::new() };
    let constants = module.constants.iter().map(|c| format!("`{codec}_{}`", c.name));
    let accessors = resources.iter().map(|r| format!("`{codec}_{}(i: u32) -> u32`", r.name));
    let level = ["frame", "resolution", "stages"].map(|name| format!("`{codec}_{name}() -> u32`"));
    constants.chain(accessors).chain(level).collect::<Vec<_>>().join(", ")
}

/// Appends the modules of the filter.
fn filter(out: &mut Text, request: &Request<'_>, form: Form) -> Result<(), ShaderError> {
    let decoded = !matches!(request.source, Source::Inline { .. });
    let hardware = match request.source {
        Source::Texture { sampling: TextureSampling::Hardware, padded, .. } => Some(match padded {
            None => shaders::FILTER_HARDWARE,
            Some(_) => shaders::FILTER_HARDWARE_PADDED,
        }),
        Source::Ring { sampling: TextureSampling::Hardware, .. } => Some(shaders::FILTER_HARDWARE_RING),
        _ => None,
    };
    match request.filter {
        None => {}
        Some(Filter::Nearest) => out.template(shaders::FILTER_NEAREST),
        Some(Filter::Linear) => match hardware {
            Some(by_texture_unit) => out.template(by_texture_unit),
            None => {
                out.template(shaders::TRILINEAR);
                out.template(form.of(shaders::FILTER_LINEAR));
            }
        },
        Some(Filter::OptimisedLinear) if decoded => {
            let text =
                "filter `optimised-linear` decodes a cell at once; what is decoded has nothing to decode";
            return Err(ShaderError(text.to_owned()));
        }
        Some(Filter::OptimisedLinear) => {
            out.template(shaders::TRILINEAR);
            out.template(shaders::FILTER_LINEAR_CELL);
        }
    }
    Ok(())
}

impl Assembled<'_> {
    /// Parses, lints, validates.
    fn prove(self, request: &Request<'_>, form: Form) -> Result<GeneratedShader, ShaderError> {
        let Self { out, mut bindings, snippet } = self;
        let entry = request.program.entry;
        let provided = provided(&request.source);
        let mapped = Mapped { wgsl: &out.wgsl, segments: &out.segments, provided: &provided };
        if let Some(snippet) = &snippet {
            // Before naga parses the text: it would blame both declarations if a snippet's clashes with a template's.
            lint::declarations(snippet)?;
        }
        let module = naga::front::wgsl::parse_str(&out.wgsl).map_err(|e| mapped.parse_error(&e))?;
        if let Some(snippet) = &snippet {
            lint::contract(snippet, &module, &mapped)?;
        }
        if !module.entry_points.iter().any(|e| e.name == entry) {
            return Err(ShaderError(format!("the template declares no entry point `{entry}`")));
        }
        validate(&module, &mapped)?;
        lay_out(&mut bindings, &module);
        let decoders = match &request.source {
            Source::Inline { codec, .. } => vec![format!("{codec}_fetch"), format!("{codec}_fetch_cell")],
            _ => Vec::new(),
        };
        let inlined_operations = inlined::operations(&module, entry, &decoders);
        let Text { wgsl, segments } = out;
        let entry = entry.to_owned();
        Ok(GeneratedShader { wgsl, segments, bindings, entry, form, inlined_operations })
    }
}

/// Stores the offsets of uniforms in their buffer.
fn lay_out(bindings: &mut [Binding], module: &naga::Module) {
    let of_uniforms = |space| space == naga::AddressSpace::Uniform;
    let Some((_, variable)) = module.global_variables.iter().find(|(_, v)| of_uniforms(v.space)) else {
        return;
    };
    let naga::TypeInner::Struct { members, .. } = &module.types[variable.ty].inner else { return };
    for binding in bindings {
        let BindingKind::Uniforms(uniforms) = &mut binding.kind else { continue };
        for (uniform, member) in uniforms.iter_mut().zip(members) {
            uniform.offset = member.offset;
            uniform.bytes = module.types[member.ty].inner.size(module.to_ctx());
        }
    }
}

/// Validates a module by the rules of WGSL, without extensions.
pub(super) fn validate(module: &naga::Module, mapped: &Mapped<'_>) -> Result<(), ShaderError> {
    let flags = naga::valid::ValidationFlags::all();
    let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty());
    validator.validate(module).map(drop).map_err(|e| mapped.validation_error(&e))
}
