//! Vector quantisation: one codebook of blocks of voxels, and one index per block.
//!
//! After P. Ning and L. Hesselink, Workshop on Volume Visualization 1992. The stream and the departures from the paper
//! stand in this crate's README.md.

pub mod decode;
mod decoder;
mod encode;
mod geometry;

use std::sync::Arc;

use cvr_codebook::Initial;
use cvr_codebook::blocks::Draw;
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
        let incomplete = |name: &str| ConfigError::Incomplete(name.to_owned());
        let integer = |name| u32::try_from(settings.integer(name)?).map_err(|_| incomplete(name));
        Ok(Box::new(encode::VqEncoder {
            block: settings.block("block")?,
            codewords: integer("codewords")?,
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
        Ok(Box::new(decoder::VqDecoder::new(&volume)?))
    }
}
