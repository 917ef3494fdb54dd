//! The shaders of the site *deferred*: every voxel of a frame, decoded once, as texels.

use cvr_shaders::DEFERRED_DECODE;

use super::{
    BindingKind, BindingLimits, GeneratedShader, PassShader, Request, ResourceSize, ShaderError, Source,
    generate, generate_passes,
};
use crate::codec::{DecodeError, Decoder, Resource, TexelFormat};
use crate::volume::{FrameIndex, Level, VolumeLayout};

/// All that decodes one frame on a device.
#[derive(Clone, Debug)]
pub struct DeferredShaders<'a> {
    /// The codec's own passes, which come first, each once; none where its snippet is called voxel by voxel.
    pub passes: Vec<PassShader>,
    /// The pass of [`generate_decode`], once per slab.
    pub pack: GeneratedShader,
    /// The codec's buffers, which the bindings of the kind [`BindingKind::Words`] count.
    pub resources: Vec<Resource<'a>>,
}

/// Why a frame cannot be decoded on a device.
#[derive(Debug, thiserror::Error)]
pub enum DeferredError {
    /// The codec has neither passes nor a snippet for this stream.
    #[error("codec `{0}` does not decode this stream in a shader")]
    NoShader(String),
    /// The stream lacks what they read.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The generator refuses them.
    #[error(transparent)]
    Shader(#[from] ShaderError),
}

impl<'a> DeferredShaders<'a> {
    /// The shaders that decode `frame` into texels of `format`: by the codec's passes if it brings any, else by its
    /// snippet.
    ///
    /// # Errors
    /// As [`generate()`] and [`generate_passes`].
    pub fn generate(
        codec: &str,
        decoder: &'a dyn Decoder,
        (frame, level): (FrameIndex, Level),
        format: TexelFormat,
        limits: BindingLimits,
    ) -> Result<Self, DeferredError> {
        let layout = decoder.layout();
        if let Some(decode) = decoder.frame_decode() {
            let own = decode.passes(frame, level)?;
            let (passes, source) = generate_passes(codec, &own, layout, (frame, level), limits)?;
            let pack = generate_decode(&source, layout, format, limits)?;
            return Ok(Self { passes, pack, resources: own.resources });
        }
        let shader = decoder.shader().ok_or_else(|| DeferredError::NoShader(codec.to_owned()))?;
        let resources = shader.resources(frame)?;
        let sizes = resources.iter().map(ResourceSize::of).collect();
        let source = Source::Inline { codec, module: shader.module(), resources: sizes, frame, level };
        let pack = generate_decode(&source, layout, format, limits)?;
        Ok(Self { passes: Vec::new(), pack, resources })
    }

    /// The texts, in the order in which they run.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.passes.iter().map(|pass| &pass.shader).chain([&self.pack]).map(|shader| shader.wgsl.as_str())
    }
}

/// Generates the pass that decodes a slab of a frame through `source` and writes its texels, in rows of a multiple of
/// 256 bytes, into a buffer of words. Its invocations stand for groups of voxels along x ([`voxels_per_invocation`]),
/// rows along y and slices along z; 64 of them along x form a workgroup.
///
/// # Errors
/// As [`generate()`].
pub fn generate_decode(
    source: &Source<'_>,
    layout: &VolumeLayout,
    format: TexelFormat,
    limits: BindingLimits,
) -> Result<GeneratedShader, ShaderError> {
    generate(&Request {
        templates: &[DEFERRED_DECODE],
        entry: "decode",
        bindings: &[BindingKind::Slab, BindingKind::Texels(format)],
        layout,
        source: source.clone(),
        filter: None,
        limits,
    })
}

/// Voxels that one invocation of the decode pass writes: as many scalars as share a word, or one colour.
#[must_use]
pub const fn voxels_per_invocation(format: TexelFormat, channels: u32) -> u32 {
    if channels == 1 { (4 / format.bytes()) as u32 } else { 1 }
}
