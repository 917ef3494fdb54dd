//! The passes with which a codec rebuilds a whole frame, as shaders.

use std::collections::BTreeSet;

use super::accessors::{Access, Accessors};
use super::generate::validate;
use super::inlined;
use super::lint::{self, Role, Snippet};
use super::origin::Mapped;
use super::text::{self, Text};
use super::tokens::mentions;
use super::{BindingKind, BindingLimits, Form, GeneratedShader, ShaderError, Source};
use crate::codec::{FramePass, FramePasses, Scratch};
use crate::volume::{FrameIndex, Level, VolumeLayout};

/// Functions about the frame and level that a snippet or pass may call.
const LEVEL: [&str; 3] = ["frame", "resolution", "stages"];

/// A pass, ready to be dispatched.
#[derive(Clone, Debug)]
pub struct PassShader {
    /// Its shader. Resources are bound as [`BindingKind::Words`], scratch buffers as [`BindingKind::Scratch`], each only
    /// if the pass uses it.
    pub shader: GeneratedShader,
    /// Workgroups along x, y and z.
    pub workgroups: [u32; 3],
}

/// Generates the passes of a codec in their order, then the shader that draws or packs voxels from the resulting
/// buffer.
///
/// # Errors
/// When a module does not parse or breaks the contract of [`FramePass`], names are unknown or clash, the result is too
/// small for a frame of `layout`, or the device's limits do not suffice. Messages point at the author's own file, line
/// and column where there is one.
pub fn generate_passes(
    codec: &str,
    passes: &FramePasses<'_>,
    layout: &VolumeLayout,
    (frame, level): (FrameIndex, Level),
    limits: BindingLimits,
) -> Result<(Vec<PassShader>, Source<'static>), ShaderError> {
    let source = result(codec, passes, layout)?;
    let shaders = passes.passes.iter().map(|pass| {
        let shader = generate_pass(codec, passes, pass, (frame, level), limits)?;
        Ok(PassShader { shader, workgroups: pass.workgroups })
    });
    Ok((shaders.collect::<Result<_, ShaderError>>()?, source))
}

/// The buffer that holds the frame at the end.
fn result(
    codec: &str,
    passes: &FramePasses<'_>,
    layout: &VolumeLayout,
) -> Result<Source<'static>, ShaderError> {
    let error = |problem: String| Err(ShaderError(format!("the passes of codec `{codec}`: {problem}")));
    if passes.passes.is_empty() {
        return error("there are none".to_owned());
    }
    let mut names = BTreeSet::new();
    for Scratch { name, words } in &passes.scratch {
        if !names.insert(name) {
            return error(format!("two scratch buffers are called `{name}`"));
        }
        if *words == 0 {
            return error(format!("scratch buffer `{name}` has no words"));
        }
    }
    let (name, samples) = (passes.result, layout.samples_per_frame());
    match index_of(passes, name) {
        Some((_, words)) if words < samples => error(format!(
            "the result lies in scratch buffer `{name}` of {words} words, and a frame has {samples} samples"
        )),
        Some((buffer, words)) => Ok(Source::Frame { buffer, words }),
        None => error(format!("the result is to lie in `{name}`, which is no scratch buffer")),
    }
}

/// A scratch buffer's place and words.
fn index_of(passes: &FramePasses<'_>, buffer: &str) -> Option<(usize, u64)> {
    passes.scratch.iter().enumerate().find(|(_, s)| s.name == buffer).map(|(i, s)| (i, s.words))
}

fn generate_pass(
    codec: &str,
    passes: &FramePasses<'_>,
    pass: &FramePass<'_>,
    (frame, level): (FrameIndex, Level),
    limits: BindingLimits,
) -> Result<GeneratedShader, ShaderError> {
    let FramePass { module, workgroups, .. } = pass;
    let entry = format!("{codec}_{}", pass.entry);
    let owner = format!("pass `{entry}` of codec `{codec}`");
    if workgroups.contains(&0) {
        let [x, y, z] = workgroups;
        return Err(ShaderError(format!("{owner} dispatches {x}×{y}×{z} workgroups, which is none")));
    }
    let snippet =
        Snippet { codec, file: module.file, source: module.source, role: Role::Pass { entry: &entry } };
    lint::declarations(&snippet)?;
    let provided = provided(codec, passes, pass, &owner)?;

    let mut accessors = Accessors::new(&owner, limits);
    for (resource, buffer) in passes.resources.iter().enumerate() {
        let name = format!("{codec}_{}", buffer.name);
        if mentions(module.source, &name) {
            let (read, words) = (Access { read: true, write: false }, buffer.words.len() as u64);
            accessors.add(&name, "", words, read, |first, words| BindingKind::Words {
                resource,
                first,
                words,
            })?;
        }
    }
    for used in &pass.scratch {
        let Some((buffer, words)) = index_of(passes, used.buffer) else {
            let problem = format!("{owner} uses `{}`, which is no scratch buffer of the codec", used.buffer);
            return Err(ShaderError(problem));
        };
        let (name, setter) = (format!("{codec}_{}", used.name), format!("{codec}_set_{}", used.name));
        let [read, write] = [&name, &setter].map(|name| mentions(module.source, name));
        if read || write {
            let kind = |first, words| BindingKind::Scratch { buffer, first, words, written: write };
            accessors.add(&name, &setter, words, Access { read, write }, kind)?;
        }
    }
    let (declarations, bindings) = accessors.finish(0)?;

    let mut out = Text::default();
    let constants = text::codec_constants(codec, &module.constants)?;
    out.generated(&format!("constants of codec {codec}"), &constants);
    out.generated(&format!("buffers of pass {entry}"), &declarations);
    let level = text::level_accessors(codec, module.source, frame, level);
    out.generated(&format!("level of codec {codec}"), &level);
    out.file(module.file, module.source, true);

    let mapped = Mapped { wgsl: &out.wgsl, segments: &out.segments, provided: &provided };
    let parsed = naga::front::wgsl::parse_str(&out.wgsl).map_err(|e| mapped.parse_error(&e))?;
    lint::contract(&snippet, &parsed, &mapped)?;
    validate(&parsed, &mapped)?;
    let Text { wgsl, segments } = out;
    let inlined_operations = inlined::operations(&parsed, &entry, &[]);
    Ok(GeneratedShader { wgsl, segments, bindings, entry, form: Form::Unrolled, inlined_operations })
}

/// A list of the declarations that the generator adds to a pass. Names must differ, and no buffer may have two.
fn provided(
    codec: &str,
    passes: &FramePasses<'_>,
    pass: &FramePass<'_>,
    owner: &str,
) -> Result<String, ShaderError> {
    let constants = pass.module.constants.iter().map(|c| (c.name.to_owned(), ""));
    let resources = passes.resources.iter().map(|r| (r.name.to_owned(), "(i: u32) -> u32"));
    let reads = pass.scratch.iter().map(|s| (s.name.to_owned(), "(i: u32) -> u32"));
    let writes = pass.scratch.iter().map(|s| (format!("set_{}", s.name), "(i: u32, word: u32)"));
    let level = LEVEL.iter().map(|name| ((*name).to_owned(), "() -> u32"));
    let all: Vec<_> = constants.chain(resources).chain(reads).chain(writes).chain(level).collect();
    let mut names = BTreeSet::new();
    if let Some((name, _)) = all.iter().find(|(name, _)| !names.insert(name)) {
        return Err(ShaderError(format!(
            "{owner}: two of its constants, resources and buffers are called `{codec}_{name}` ({} are taken)",
            LEVEL.map(|name| format!("`{name}`")).join(", ")
        )));
    }
    let mut buffers = BTreeSet::new();
    if let Some(twice) = pass.scratch.iter().find(|used| !buffers.insert(used.buffer)) {
        let problem = format!("{owner} has scratch buffer `{}` under two names", twice.buffer);
        return Err(ShaderError(problem));
    }
    let words: Vec<_> = all.iter().map(|(name, signature)| format!("`{codec}_{name}{signature}`")).collect();
    Ok(words.join(", "))
}

#[cfg(test)]
mod tests;
