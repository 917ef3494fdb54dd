//! The texture of the site *host*: the stream's own blocks, or texels of decoded values; with the reason.

use std::fmt;

use cvr_core::codec::{BlockFormat, BlockTexture, DecodedForm, TexelFormat};
use cvr_core::shader::{Source, TextureSampling};
use cvr_engine::{BlockFallback, TextureChoice};

use super::coded::CodedFrame;
use super::target::{DrawError, Target};

/// The blocks of a frame if this device's texture units decode them, else the reason. `None` if the codec has no
/// blocks, and for the mirror.
#[must_use]
pub fn blocks<'d>(target: &Target, coded: CodedFrame<'d>) -> Option<Result<BlockTexture<'d>, BlockFallback>> {
    let Target::Device(device) = target else { return None };
    let CodedFrame { decoder, key: (frame, level), .. } = coded;
    let blocks = decoder.block_texture(frame, level)?;
    let takes = device.capabilities().blocks(blocks.format, decoder.layout().channels);
    Some(takes.map(|()| blocks))
}

/// What holds a frame at the site *host*.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum HostTexture {
    /// The mirror draws from the frame that the CPU decoded.
    Mirror {
        /// The codec's blocks, which a device's texture unit might decode.
        blocks: Option<BlockFormat>,
        /// Format of decoded values on a device with all features.
        texels: TexelFormat,
    },
    /// Unchanged blocks of the stream.
    Blocks(BlockFormat),
    /// Decoded values.
    Texels {
        /// Texel format, filtering unit, and fallback.
        choice: TextureChoice,
        /// Why they are not the codec's blocks, if the codec has blocks.
        blocks: Option<BlockFallback>,
    },
}

impl HostTexture {
    /// The texture for a frame at a level. A run makes the same choice before it uploads.
    ///
    /// # Errors
    /// When the device has no texture for such a volume.
    pub fn of(target: &Target, coded: CodedFrame<'_>) -> Result<Self, DrawError> {
        let CodedFrame { decoder, key, .. } = coded;
        let (layout, form) = (coded.layout(), decoder.decoded_form());
        let Target::Device(device) = target else {
            let blocks = decoder.block_texture(key.0, key.1).filter(|_| layout.channels == 1);
            return Ok(Self::Mirror { blocks: blocks.map(|blocks| blocks.format), texels: form.format });
        };
        let blocks = match blocks(target, coded) {
            Some(Ok(blocks)) => return Ok(Self::Blocks(blocks.format)),
            Some(Err(reason)) => Some(reason),
            None => None,
        };
        Ok(Self::Texels { choice: device.capabilities().texture(form, layout.extent)?, blocks })
    }

    /// The voxel source of the drawing shader.
    #[must_use]
    pub fn source(&self, coded: CodedFrame<'_>) -> Source<'static> {
        let CodedFrame { decoder, key: (frame, level), .. } = coded;
        let plain = Source::Texture {
            form: decoder.decoded_form(),
            sampling: TextureSampling::Hardware,
            padded: None,
        };
        match *self {
            Self::Mirror { .. } => plain,
            Self::Texels { choice: TextureChoice { form, sampling, .. }, .. } => {
                Source::Texture { form, sampling, padded: None }
            }
            Self::Blocks(format) => {
                let Some(blocks) = decoder.block_texture(frame, level) else { return plain };
                let extent = coded.layout().extent;
                let padded = Some(format.padded(extent)).filter(|size| *size != extent.to_array());
                // Block texels read as fractions of a range, like 8-bit texels.
                let form =
                    DecodedForm { format: TexelFormat::Unorm8, scale: blocks.scale, offset: blocks.offset };
                Source::Texture { form, sampling: TextureSampling::Hardware, padded }
            }
        }
    }
}

impl fmt::Display for HostTexture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mirror { blocks, texels } => {
                f.write_str("no texture, the CPU mirror draws from the decoded frame; a device would have ")?;
                if let Some(format) = blocks {
                    write!(f, "{} where it takes them in 3-D textures, else ", block_name(*format))?;
                }
                write!(f, "texels of {}", texel_name(*texels))
            }
            Self::Blocks(format) => {
                write!(f, "{} as the stream has them, which the texture unit decodes", block_name(*format))
            }
            Self::Texels { choice, blocks } => {
                write!(f, "texels of {}", texel_name(choice.form.format))?;
                match (blocks, choice.fallback) {
                    (Some(blocks), Some(fallback)) => write!(f, ": {blocks}; {fallback}"),
                    (Some(blocks), None) => write!(f, ": {blocks}"),
                    (None, Some(fallback)) => write!(f, ": {fallback}"),
                    (None, None) => f.write_str(", the smallest that hold what the CPU decodes"),
                }
            }
        }
    }
}

const fn block_name(format: BlockFormat) -> &'static str {
    match format {
        BlockFormat::Bc4 => "blocks of BC4 (4×4 voxels of a slice in 8 bytes)",
    }
}

const fn texel_name(format: TexelFormat) -> &'static str {
    match format {
        TexelFormat::Unorm8 => "8-bit unorm",
        TexelFormat::Unorm16 => "16-bit unorm",
        TexelFormat::Float16 => "half precision",
        TexelFormat::Float32 => "single precision",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::codec::{Decoder, encode_temporary};
    use cvr_core::volume::{Extent, FiniteVolume, FrameIndex, Level, SampleType};
    use cvr_engine::TextureFallback;

    use crate::input::{Generator, generate};
    use crate::registry::Names;

    const KEY: (FrameIndex, Level) = (FrameIndex::FIRST, Level::FULL);

    /// A decoder of a volume whose edges are not multiples of a block's.
    fn decoder(codec: &str) -> Box<dyn Decoder> {
        let names = Names::new().unwrap();
        let codec = names.codecs().get(codec).unwrap();
        let volume =
            generate(Generator::SheppLogan, Extent::new(9, 8, 6).unwrap(), SampleType::U8, 0).unwrap();
        let settings = codec.info().default_settings();
        let stream = encode_temporary(codec.as_ref(), &settings, &FiniteVolume::new(volume)).unwrap();
        codec.decoder(std::sync::Arc::new(stream)).unwrap()
    }

    fn coded<'a>(codec: &'a str, decoder: &'a dyn Decoder) -> CodedFrame<'a> {
        CodedFrame { codec, decoder, key: KEY }
    }

    #[test]
    fn a_texture_says_what_it_holds_and_why() {
        let mirror = Target::Cpu { reason: None };
        let of = |id: &str| HostTexture::of(&mirror, coded(id, decoder(id).as_ref())).unwrap().to_string();
        let start = "no texture, the CPU mirror draws from the decoded frame; a device would have ";
        assert_eq!(of("raw"), format!("{start}texels of 8-bit unorm"));
        let blocks = of("bc4");
        assert!(blocks.starts_with(&format!("{start}blocks of BC4 (")), "{blocks}");
        assert!(blocks.contains(" else texels of "), "{blocks}");
        let texels = |fallback, blocks| {
            let choice =
                TextureChoice { form: DecodedForm::FLOAT32, sampling: TextureSampling::Manual, fallback };
            HostTexture::Texels { choice, blocks }.to_string()
        };
        let plain = "texels of single precision, the smallest that hold what the CPU decodes";
        assert_eq!(texels(None, None), plain);
        let both = texels(Some(TextureFallback::ManualForFloat32), Some(BlockFallback::NoFormat));
        assert!(
            both.contains("no 3-D textures of the codec's blocks") && both.contains("cannot be filtered"),
            "{both}"
        );
    }

    #[test]
    fn shaders_of_blocks_know_the_padding_and_those_of_texels_the_fallback() {
        let bc4 = decoder("bc4");
        let source = |texture: HostTexture| texture.source(coded("bc4", bc4.as_ref()));
        let Source::Texture { form, padded, .. } = source(HostTexture::Blocks(BlockFormat::Bc4)) else {
            panic!("no texture")
        };
        assert_eq!((form.format, padded), (TexelFormat::Unorm8, Some([12, 8, 6])));
        let choice = TextureChoice {
            form: DecodedForm::FLOAT32,
            sampling: TextureSampling::Manual,
            fallback: Some(TextureFallback::ManualForFloat32),
        };
        let Source::Texture { form, sampling, padded } = source(HostTexture::Texels { choice, blocks: None })
        else {
            panic!("no texture")
        };
        assert_eq!((form, sampling, padded), (DecodedForm::FLOAT32, TextureSampling::Manual, None));
    }
}
