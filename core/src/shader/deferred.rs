//! Shaders that decode voxels into texels: of a whole frame for the site *deferred*, of one layer for the site *ring*.

use cvr_shaders::{self as shaders, DEFERRED_DECODE, Template};

use super::text::layer_places;
use super::{
    BindingLimits, GeneratedShader, Module, PassShader, Program, Request, ResourceSize, ShaderError, Source,
    Variable, generate, generate_passes, snippet_resources,
};
use crate::codec::{DecodeError, Decoder, Resource, TexelFormat};
use crate::volume::{Axis, FrameIndex, Level, VolumeLayout};

/// All that decodes one frame on a device.
#[derive(Clone, Debug)]
pub struct DeferredShaders<'a> {
    /// The codec's own passes. Each runs once, before `pack`. Empty if the snippet is called voxel by voxel.
    pub passes: Vec<PassShader>,
    /// The pass of [`generate_decode`]. It runs once per chunk of layers.
    pub pack: GeneratedShader,
    /// The codec's buffers. Bindings of the kind [`super::BindingKind::Words`] index them.
    pub resources: Vec<Resource<'a>>,
}

/// Why a frame cannot be decoded on a device.
#[derive(Debug, thiserror::Error)]
pub enum DeferredError {
    /// The codec has neither passes nor a snippet for this stream.
    #[error("codec `{0}` does not decode this stream in a shader")]
    NoShader(String),
    /// The stream lacks data that the shaders read.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The generator refuses them.
    #[error(transparent)]
    Shader(#[from] ShaderError),
}

impl<'a> DeferredShaders<'a> {
    /// The shaders that decode `frame` into texels of `format`: with the codec's passes if it has any, else with its
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
        if let Some(decode) = decoder.frame_decode() {
            let layout = &decoder.layout().at_resolution(level.resolution);
            let mut own = decode.passes(frame, level)?;
            own.resources.extend(decoder.references(frame, level)?.resources()?);
            let (passes, source) = generate_passes(codec, &own, layout, (frame, level), limits)?;
            let pack = generate_decode(&source, layout, (format, Axis::Z), limits)?;
            return Ok(Self { passes, pack, resources: own.resources });
        }
        Self::generate_layers(codec, decoder, (frame, level), (format, Axis::Z), limits)
    }

    /// The shader that decodes single layers across `axis` with the codec's snippet. Passes cannot do this: they
    /// rebuild whole frames.
    ///
    /// # Errors
    /// As [`generate()`], and when the codec has no snippet.
    pub fn generate_layers(
        codec: &str,
        decoder: &'a dyn Decoder,
        (frame, level): (FrameIndex, Level),
        (format, axis): (TexelFormat, Axis),
        limits: BindingLimits,
    ) -> Result<Self, DeferredError> {
        let shader = decoder.shader().ok_or_else(|| DeferredError::NoShader(codec.to_owned()))?;
        let resources = snippet_resources(codec, decoder, shader, (frame, level))?;
        let sizes = resources.iter().map(ResourceSize::of).collect();
        let source = Source::Inline { codec, module: shader.module(), resources: sizes, frame, level };
        let pack = generate_decode(
            &source,
            &decoder.layout().at_resolution(level.resolution),
            (format, axis),
            limits,
        )?;
        Ok(Self { passes: Vec::new(), pack, resources })
    }

    /// The texts, in the order in which they run.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.passes.iter().map(|pass| &pass.shader).chain([&self.pack]).map(|shader| shader.wgsl.as_str())
    }
}

/// Generates the pass that decodes layers of a frame through `source` into a buffer of words. It writes texels layer by
/// layer across `axis` (z if the texture is a frame), in rows of a multiple of 256 bytes. Invocations are groups of
/// voxels along a row ([`voxels_per_invocation`]) in x, rows in y, and layers in z. A workgroup is 64 invocations along
/// x.
///
/// # Errors
/// As [`generate()`].
pub fn generate_decode(
    source: &Source<'_>,
    layout: &VolumeLayout,
    (format, axis): (TexelFormat, Axis),
    limits: BindingLimits,
) -> Result<GeneratedShader, ShaderError> {
    let program = Program {
        modules: vec![
            DEFERRED_DECODE.into(),
            texel(format).into(),
            Module::Generated {
                purpose: "layers of voxels",
                source: layer_places(axis, |function| function == "voxel_of_layer("),
            },
        ],
        offered: Vec::new(),
        entry: "decode",
        variables: vec![
            Variable::Uniform { name: "slab", wgsl_type: "Slab" },
            Variable::written("texels", "array<u32>"),
        ],
    };
    generate(&Request { program: &program, layout, source: source.clone(), filter: None, limits })
}

/// The module that packs a value into a texel.
const fn texel(format: TexelFormat) -> Template {
    match format {
        TexelFormat::Unorm8 => shaders::TEXEL_UNORM8,
        TexelFormat::Unorm16 => shaders::TEXEL_UNORM16,
        TexelFormat::Float16 => shaders::TEXEL_FLOAT16,
        TexelFormat::Float32 => shaders::TEXEL_FLOAT32,
    }
}

/// Voxels that one invocation of the decode pass writes: the scalars of one word, or one colour.
#[must_use]
pub const fn voxels_per_invocation(format: TexelFormat, channels: u32) -> u32 {
    if channels == 1 { (4 / format.bytes()) as u32 } else { 1 }
}
