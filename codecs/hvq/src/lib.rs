//! Hierarchical vector quantisation: the mean of a block of 4³ voxels, a codebook of what the means of its eight 2³
//! sub-blocks differ from it, and one of what the voxels differ from those.
//!
//! After J. Schneider and R. Westermann, IEEE Visualization 2003. The stream and the departures from the paper stand in
//! this crate's README.md.

mod blocks;
pub mod decode;
mod decoder;
mod encode;
mod geometry;
mod stage;
mod training;

use std::sync::Arc;

use cvr_codebook::Initial;
use cvr_codebook::blocks::Draw;
use cvr_core::codec::{
    Block, Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Paper, Setting,
    SettingKind, Settings,
};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::Extent;

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
            kind: SettingKind::Choice(&["shared", "per-frame"]),
            default: "shared",
        },
        Setting {
            name: "training_blocks",
            doc: "blocks that a codebook is trained on, drawn by chance; all where there are no more",
            kind: SettingKind::Integer { min: 1, max: 1 << 24 },
            default: "131072",
        },
        Setting {
            name: "draw",
            doc: "how training blocks are drawn where there are more: uniform = by chance alone; stratified = half of them \
                  evenly over classes of variance, so that rare edges are in it",
            kind: SettingKind::Choice(Draw::NAMES),
            default: "uniform",
        },
        Setting {
            name: "iterations",
            doc: "rounds of training at most; it ends before, once a round gains less than a thousandth",
            kind: SettingKind::Integer { min: 0, max: 1000 },
            default: "50",
        },
        Setting {
            name: "init",
            doc: "first codebook, which training refines: pca = cells cut across their principal axis; pnn = pairs of \
                  nearest neighbours united; scalar = a grid of scalar quantisers; random = blocks drawn by chance",
            kind: SettingKind::Choice(Initial::NAMES),
            default: "pca",
        },
        Setting {
            name: "seed",
            doc: "of the choice of training blocks, and of what else chance decides",
            kind: SettingKind::Integer { min: 0, max: i64::MAX },
            default: "1",
        },
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

    /// Of 4³ voxels.
    fn block(&self, _settings: &Settings) -> Option<Block> {
        Extent::cube(4).ok().map(Block)
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        let incomplete = |name: &str| ConfigError::Incomplete(name.to_owned());
        let integer = |name| u32::try_from(settings.integer(name)?).map_err(|_| incomplete(name));
        Ok(Box::new(encode::HvqEncoder {
            codewords: [integer("coarse_codewords")?, integer("detail_codewords")?],
            mean_bits: settings.text("mean_bits")?.parse().ok(),
            codeword_bits: integer("codeword_bits")?,
            per_frame: settings.text("tables")? == "per-frame",
            training_blocks: integer("training_blocks")?.into(),
            iterations: integer("iterations")?,
            draw: Draw::named(settings.text("draw")?).ok_or_else(|| incomplete("draw"))?,
            initial: Initial::named(settings.text("init")?).ok_or_else(|| incomplete("init"))?,
            seed: u64::try_from(settings.integer("seed")?).map_err(|_| incomplete("seed"))?,
        }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(decoder::HvqDecoder::new(&volume)?))
    }
}
