//! Vector quantisation: one codebook of blocks of voxels, and one index per block.
//!
//! After P. Ning and L. Hesselink, Workshop on Volume Visualization 1992. This crate's README.md specifies the stream
//! and lists the differences from the paper.

pub mod decode;
mod encode;
mod geometry;
mod reader;

use std::sync::Arc;

use cvr_codebook::settings::{self, TrainingSettings, natural};
use cvr_core::codec::{
    Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Paper, Setting, SettingKind,
    Settings,
};
use cvr_core::container::EncodedVolume;

pub use geometry::{Geometry, Parameters, TrainingRecord};

/// Tensor and shader resource: the codewords.
const CODEBOOK: &str = "codebook";
/// Tensor and shader resource: one index per block.
const INDEX: &str = "index";
/// Longest axis of a block.
const LONGEST: u32 = 16;

static INFO: CodecInfo = CodecInfo {
    id: "vq",
    summary: "one codebook of blocks of voxels, and one index per block",
    stream_version: 1,
    decoded_by: &[DecodedBy::Shader, DecodedBy::Cpu],
    fetch_cell: true,
    paper: Some(Paper {
        authors: "P. Ning, L. Hesselink",
        title: "Vector Quantization for Volume Rendering",
        venue: "Workshop on Volume Visualization 1992",
    }),
    settings: &[
        Setting {
            name: "block",
            doc: "size in voxels of the block that one index stands for",
            kind: SettingKind::Block { max: LONGEST },
            default: "2",
        },
        Setting {
            name: "codewords",
            doc: "size of the codebook; an index takes ceil(log2(codewords)) bits",
            kind: SettingKind::Integer { min: 2, max: 65536 },
            default: "256",
        },
        Setting {
            name: "codeword_bits",
            doc: "bits of one value of a codeword",
            kind: SettingKind::OneOf(&[8, 16]),
            default: "8",
        },
        Setting {
            name: "tables",
            doc: "shared = one codebook for all frames; per-frame = one for each",
            kind: settings::TABLES,
            default: "shared",
        },
        settings::TRAINING_BLOCKS,
        settings::DRAW,
        settings::ITERATIONS,
        settings::INIT,
        settings::SEED,
    ],
    methods: &["tables", "draw", "init"],
};

/// The codec `vq`.
#[derive(Copy, Clone, Debug, Default)]
pub struct Vq;

/// The codec, as a registry takes it.
#[must_use]
pub fn codec() -> Arc<dyn Codec> {
    Arc::new(Vq)
}

impl Codec for Vq {
    fn info(&self) -> &CodecInfo {
        &INFO
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        Ok(Box::new(encode::VqEncoder {
            block: settings.block("block")?,
            codewords: natural(settings, "codewords")?,
            codeword_bits: natural(settings, "codeword_bits")?,
            training: TrainingSettings::of(settings)?,
        }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(reader::Reader::open(&volume)?))
    }
}
