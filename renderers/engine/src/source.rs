//! The voxel source of a drawing.

use std::borrow::Cow;
use std::sync::Arc;

use cvr_core::codec::{Constant, Decoder, Resource};
use cvr_core::render::{Filter, Template};
use cvr_core::shader::{
    GeneratedShader, Program, Request, ResourceSize, ShaderError, Source, snippet_resources,
};
use cvr_core::volume::{FrameIndex, Level, VolumeLayout};

use crate::{Device, EngineError, VolumeTexture};

/// Where voxels come from.
#[derive(Clone, Debug)]
pub enum DrawSource<'a> {
    /// Decoded in the shader, at every fetch.
    Inline {
        /// Codec id.
        codec: &'a str,
        /// The opened stream.
        decoder: &'a dyn Decoder,
        /// Time step.
        frame: FrameIndex,
        /// Resolution and stages.
        level: Level,
    },
    /// Decoded layer by layer in every picture, for plans with [`cvr_core::render::Stage::Layers`].
    Ring {
        /// Codec id.
        codec: &'a str,
        /// The opened stream.
        decoder: &'a dyn Decoder,
        /// Time step.
        frame: FrameIndex,
        /// Resolution and stages.
        level: Level,
    },
    /// Decoded before, on the CPU or the device.
    Texture(Arc<VolumeTexture>),
    /// Buffers, which modules of their owner read.
    Buffers(Arc<VolumeBuffers>),
}

/// A frame in buffers of words, and the modules that fetch its voxels ([`Source::Buffers`]).
#[derive(Clone, Debug)]
pub struct VolumeBuffers {
    /// Shape of the volume.
    pub layout: VolumeLayout,
    /// Prefix of constants and accessors.
    pub name: &'static str,
    /// The modules.
    pub modules: &'static [Template],
    /// Their constants.
    pub constants: Vec<Constant>,
    /// Their buffers.
    pub buffers: Vec<Resource<'static>>,
}

impl VolumeBuffers {
    /// As the shader generator wants it.
    #[must_use]
    pub fn source(&self) -> Source<'static> {
        Source::Buffers {
            name: self.name,
            modules: self.modules,
            constants: self.constants.clone(),
            buffers: self.buffers.iter().map(ResourceSize::of).collect(),
        }
    }
}

/// A source as the generator and the bindings want it.
pub(crate) struct Voxels<'a> {
    /// Shape of the voxels at the level.
    pub(crate) layout: VolumeLayout,
    pub(crate) source: Source<'a>,
    pub(crate) buffers: Vec<Resource<'a>>,
    pub(crate) texture: Option<&'a VolumeTexture>,
}

impl Voxels<'_> {
    /// The shader of a program that fetches these voxels, through a filter if the program needs one.
    pub(crate) fn shader(
        &self,
        device: &Device,
        program: &Program,
        filter: Option<Filter>,
    ) -> Result<Arc<GeneratedShader>, ShaderError> {
        let (layout, source, limits) = (&self.layout, self.source.clone(), device.binding_limits());
        device.shader(&Request { program, layout, source, filter, limits })
    }
}

impl DrawSource<'_> {
    /// Shape of the drawn voxels at the level.
    #[must_use]
    pub fn layout(&self) -> VolumeLayout {
        match self {
            Self::Inline { decoder, level, .. } | Self::Ring { decoder, level, .. } => {
                decoder.layout().at_resolution(level.resolution)
            }
            Self::Texture(texture) => texture.layout().clone(),
            Self::Buffers(volume) => volume.layout.clone(),
        }
    }

    pub(crate) fn voxels(&self) -> Result<Voxels<'_>, EngineError> {
        let layout = self.layout();
        match self {
            Self::Inline { codec, decoder, frame, level } => {
                let shader = decoder.shader().ok_or_else(|| {
                    EngineError::Unsupported(format!(
                        "codec `{codec}` does not decode this stream in a shader"
                    ))
                })?;
                let buffers = snippet_resources(codec, *decoder, shader, (*frame, *level))?;
                let resources = buffers.iter().map(ResourceSize::of).collect();
                let (module, frame, level) = (shader.module(), *frame, *level);
                let source = Source::Inline { codec, module, resources, frame, level };
                Ok(Voxels { layout, source, buffers, texture: None })
            }
            Self::Ring { .. } => {
                let text = "a ring of layers is drawn from by plans that decode layer by layer, and this one does not";
                Err(EngineError::Unsupported(text.to_owned()))
            }
            Self::Texture(texture) => {
                Ok(Voxels { layout, source: texture.source(), buffers: Vec::new(), texture: Some(texture) })
            }
            Self::Buffers(volume) => {
                let buffers = volume.buffers.iter();
                let buffers = buffers
                    .map(|buffer| Resource { name: buffer.name, words: Cow::Borrowed(&*buffer.words) })
                    .collect();
                Ok(Voxels { layout, source: volume.source(), buffers, texture: None })
            }
        }
    }
}
