//! BC4, known as RGTC1 too: 4×4 blocks of a slice, each of two 8-bit endpoints and a 3-bit index per voxel.
//!
//! The blocks are those that texture units decode: where a device has them in 3-D textures, the site *host* uploads the
//! stream as it is. The stream, the arithmetic and the sources stand in this crate's README.md.

pub mod block;
pub mod decode;
mod decoder;
mod encode;
mod geometry;
mod scale;
mod search;

use std::sync::Arc;

use cvr_core::codec::{
    Block, Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Paper, Setting,
    SettingKind, Settings,
};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::Extent;

pub use geometry::Geometry;
pub use scale::Scale;
pub use search::{Quality, encode_block};

/// Tensor and shader resource: the blocks.
const BLOCKS: &str = "blocks";

static INFO: CodecInfo = CodecInfo {
    id: "bc4",
    summary: "BC4 texture blocks: 4×4 voxels of a slice in 8 bytes, two endpoints and 3 bits per voxel",
    stream_version: 1,
    decoded_by: &[DecodedBy::Shader, DecodedBy::Cpu],
    fetch_cell: true,
    paper: Some(Paper {
        authors: "P. Brown (NVIDIA)",
        title: "EXT_texture_compression_rgtc",
        venue: "OpenGL extension 332, 2008",
    }),
    settings: &[Setting {
        name: "quality",
        doc: "how endpoints are found: range (minimum and maximum of the block) or search (least error, both modes)",
        kind: SettingKind::Choice(Quality::NAMES),
        default: "search",
    }],
    methods: &["quality"],
};

/// The codec `bc4`.
#[derive(Copy, Clone, Debug, Default)]
pub struct Bc4;

/// The codec, as a registry takes it.
#[must_use]
pub fn codec() -> Arc<dyn Codec> {
    Arc::new(Bc4)
}

impl Codec for Bc4 {
    fn info(&self) -> &CodecInfo {
        &INFO
    }

    /// Of 4×4 voxels of one slice.
    fn block(&self, _settings: &Settings) -> Option<Block> {
        Extent::new(4, 4, 1).ok().map(Block)
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        let quality = Quality::from_name(settings.text("quality")?)
            .ok_or_else(|| ConfigError::Incomplete("quality".to_owned()))?;
        Ok(Box::new(encode::Bc4Encoder { quality }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(decoder::Bc4Decoder::new(&volume)?))
    }
}
