//! Fixed-rate zfp: blocks of 4³ voxels. Each block is transformed and coded with the same number of bits.
//!
//! After P. Lindstrom, IEEE Transactions on Visualization and Computer Graphics 20 (12), 2014, and the description of
//! the algorithm in zfp's documentation. This crate's README.md specifies the stream and lists the differences from
//! zfp.

pub mod decode;
mod encode;
mod geometry;
mod lift;
mod planes;
mod reader;

use std::sync::Arc;

use cvr_core::codec::{
    Block, Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Paper, Setting,
    SettingKind, Settings,
};
use cvr_core::container::EncodedVolume;

pub use geometry::{Geometry, Parameters, block_bits};

/// Tensor and shader resource: the bits of all blocks.
const BLOCKS: &str = "blocks";

static INFO: CodecInfo = CodecInfo {
    id: "zfp",
    summary: "blocks of 4³ voxels under one exponent, transformed, bit plane by bit plane to a fixed rate",
    stream_version: 1,
    decoded_by: &[DecodedBy::Shader, DecodedBy::Cpu],
    fetch_cell: true,
    paper: Some(Paper {
        authors: "P. Lindstrom",
        title: "Fixed-Rate Compressed Floating-Point Arrays",
        venue: "IEEE Transactions on Visualization and Computer Graphics 20 (12), 2014",
    }),
    settings: &[Setting {
        name: "rate",
        doc: "bits per sample, rounded to whole bits of a block of 64 samples: steps of 1/64, halves upwards",
        kind: SettingKind::Float { min: geometry::LOWEST_RATE, max: geometry::HIGHEST_RATE },
        default: "4",
    }],
    methods: &[],
};

/// The codec `zfp`.
#[derive(Copy, Clone, Debug, Default)]
pub struct Zfp;

/// The codec, as a registry takes it.
#[must_use]
pub fn codec() -> Arc<dyn Codec> {
    Arc::new(Zfp)
}

impl Codec for Zfp {
    fn info(&self) -> &CodecInfo {
        &INFO
    }

    /// Blocks of 4³ voxels.
    fn block(&self, _settings: &Settings) -> Option<Block> {
        Some(geometry::block())
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        Ok(Box::new(encode::ZfpEncoder { block_bits: block_bits(settings.float("rate")?) }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(reader::Reader::open(&volume)?))
    }
}
