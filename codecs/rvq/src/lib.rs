//! Residual vector quantisation: a block is a sum of one codeword of each of several stages.
//!
//! After R. Parys and G. Knittel, *Giga-Voxel Rendering from Compressed Data on a Display Wall*, WSCG 2009. The stream and
//! the departures from the paper stand in this crate's README.md.

pub mod decode;
mod encode;
mod reader;
mod settings;
pub mod stream;

use std::sync::Arc;

use cvr_core::codec::{
    Block, Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Paper, Settings,
};
use cvr_core::container::EncodedVolume;

static INFO: CodecInfo = CodecInfo {
    id: "rvq",
    summary: "a sum of codewords, each on what the stages before it leave",
    stream_version: 1,
    decoded_by: &[DecodedBy::Shader, DecodedBy::Cpu],
    fetch_cell: true,
    paper: Some(Paper {
        authors: "R. Parys, G. Knittel",
        title: "Giga-Voxel Rendering from Compressed Data on a Display Wall",
        venue: "Journal of WSCG 17, 2009",
    }),
    settings: settings::SETTINGS,
    methods: settings::METHODS,
};

/// The codec `rvq`.
#[derive(Copy, Clone, Debug, Default)]
pub struct Rvq;

/// The codec, as a registry takes it.
#[must_use]
pub fn codec() -> Arc<dyn Codec> {
    Arc::new(Rvq)
}

impl Codec for Rvq {
    fn info(&self) -> &CodecInfo {
        &INFO
    }

    /// Those of the setting.
    fn stages(&self, settings: &Settings) -> u8 {
        settings::stages(settings).ok().and_then(|stages| u8::try_from(stages).ok()).unwrap_or(1)
    }

    /// Blocks of 4³, 2³ and 1³ voxels.
    fn resolutions(&self, _settings: &Settings) -> u8 {
        stream::RESOLUTIONS as u8
    }

    /// Of 4³ voxels.
    fn block(&self, _settings: &Settings) -> Option<Block> {
        Some(stream::block(0))
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        Ok(Box::new(encode::RvqEncoder { options: settings::Options::of(settings)? }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(reader::Reader::open(&volume)?))
    }
}
