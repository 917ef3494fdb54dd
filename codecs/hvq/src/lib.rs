//! Hierarchical vector quantisation of blocks of 4³ voxels: the mean of a block; a codebook of differences between the
//! means of its eight 2³ sub-blocks and that mean; and a codebook of differences between the voxels and those means.
//!
//! After J. Schneider and R. Westermann, IEEE Visualization 2003. This crate's README.md specifies the stream and lists
//! the differences from the paper.

mod blocks;
pub mod decode;
mod encode;
mod geometry;
mod reader;
mod stage;
mod training;

use std::sync::Arc;

use cvr_codebook::settings::{self, TrainingSettings, natural};
use cvr_core::codec::{
    Block, Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Paper, Setting,
    SettingKind, Settings,
};
use cvr_core::container::EncodedVolume;

pub use geometry::{Geometry, Parameters, Plane, Stage, StageRecord, TrainingRecord};
pub use stage::StageParameters;

/// Tensor and shader resource: the codewords of both stages.
const CODEBOOK: &str = "codebook";
/// Tensor and shader resource: means and indices.
const INDEX: &str = "index";
/// Means, coarse and detail.
const STAGES: u8 = 3;
/// Most codewords of a table.
const MOST_CODEWORDS: u32 = 1 << 16;

const CODEWORDS: SettingKind = SettingKind::Integer { min: 2, max: MOST_CODEWORDS as i64 };

static INFO: CodecInfo = CodecInfo {
    id: "hvq",
    summary: "means of blocks of 4³ voxels, and codebooks of the differences of sub-blocks and of voxels",
    stream_version: 1,
    decoded_by: &[DecodedBy::Shader, DecodedBy::Cpu],
    fetch_cell: true,
    paper: Some(Paper {
        authors: "J. Schneider, R. Westermann",
        title: "Compression Domain Volume Rendering",
        venue: "IEEE Visualization 2003",
    }),
    settings: &[
        Setting {
            name: "coarse_codewords",
            doc: "size of the codebook of sub-blocks; an index takes ceil(log2(coarse_codewords)) bits",
            kind: CODEWORDS,
            default: "256",
        },
        Setting {
            name: "detail_codewords",
            doc: "size of the codebook of voxels; an index takes ceil(log2(detail_codewords)) bits",
            kind: CODEWORDS,
            default: "256",
        },
        Setting {
            name: "mean_bits",
            doc: "bits of a block's mean; auto = 8 for samples of 8 bits, else 16",
            kind: SettingKind::Choice(&["auto", "8", "16"]),
            default: "auto",
        },
        Setting {
            name: "codeword_bits",
            doc: "bits of one value of a codeword",
            kind: SettingKind::OneOf(&[8, 16]),
            default: "8",
        },
        Setting {
            name: "tables",
            doc: "shared = one pair of codebooks for all frames; per-frame = one for each, trained from the one before",
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

/// The codec `hvq`.
#[derive(Copy, Clone, Debug, Default)]
pub struct Hvq;

/// The codec, as a registry takes it.
#[must_use]
pub fn codec() -> Arc<dyn Codec> {
    Arc::new(Hvq)
}

impl Codec for Hvq {
    fn info(&self) -> &CodecInfo {
        &INFO
    }

    fn stages(&self, _settings: &Settings) -> u8 {
        STAGES
    }

    /// Blocks of 4³ voxels.
    fn block(&self, _settings: &Settings) -> Option<Block> {
        Some(geometry::block())
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        Ok(Box::new(encode::HvqEncoder {
            codewords: [natural(settings, "coarse_codewords")?, natural(settings, "detail_codewords")?],
            mean_bits: settings.text("mean_bits")?.parse().ok(),
            codeword_bits: natural(settings, "codeword_bits")?,
            training: TrainingSettings::of(settings)?,
        }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(reader::Reader::open(&volume)?))
    }
}
