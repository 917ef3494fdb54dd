//! Where a drawing's voxels come from.

use std::sync::Arc;

use cvr_core::codec::{Decoder, Resource};
use cvr_core::render::Filter;
use cvr_core::shader::{GeneratedShader, Program, Request, ResourceSize, ShaderError, Source};
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
    /// Decoded layer by layer in every frame, for plans that draw so ([`cvr_core::render::Stage::Layers`]).
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
}

/// A source as the generator and the bindings want it.
pub(crate) struct Voxels<'a> {
    pub(crate) layout: &'a VolumeLayout,
    pub(crate) source: Source<'a>,
    pub(crate) buffers: Vec<Resource<'a>>,
    pub(crate) texture: Option<&'a VolumeTexture>,
}

impl Voxels<'_> {
    /// The shader of a program that fetches these voxels, through a filter if it asks for one.
    pub(crate) fn shader(
        &self,
        device: &Device,
        program: &Program,
        filter: Option<Filter>,
    ) -> Result<Arc<GeneratedShader>, ShaderError> {
        let (layout, source, limits) = (self.layout, self.source.clone(), device.binding_limits());
        device.shader(&Request { program, layout, source, filter, limits })
    }
}

impl DrawSource<'_> {
    /// Shape of the volume.
    #[must_use]
    pub fn layout(&self) -> &VolumeLayout {
        match self {
            Self::Inline { decoder, .. } | Self::Ring { decoder, .. } => decoder.layout(),
            Self::Texture(texture) => texture.layout(),
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
                let buffers = shader.resources(*frame)?;
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
        }
    }
}
