//! BC4 (RGTC1): blocks of 4×4 voxels of a slice. Each has two 8-bit endpoints and a 3-bit index per voxel.
//!
//! Texture units can decode these blocks. If a device supports them in 3-D textures, the site *host* uploads the stream
//! unchanged. This crate's README.md specifies stream, arithmetic and sources.

pub mod block;
pub mod decode;
mod records;
mod scale;
mod search;

use std::sync::Arc;

use cvr_core::codec::{Codec, CodecInfo, DecodedBy, Paper, Setting, SettingKind};
use cvr_core::kit::CodecOfBlocks;

pub use records::Records;
pub use scale::Scale;
pub use search::{Quality, encode_block};

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
pub const BC4: CodecOfBlocks<Records> = CodecOfBlocks::new();

/// The codec, as a registry takes it.
#[must_use]
pub fn codec() -> Arc<dyn Codec> {
    Arc::new(BC4)
}
