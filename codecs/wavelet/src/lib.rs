//! Wavelets: the transform of whole volumes, quantised and entropy-coded, and blocks that a shader decodes.
//!
//! After S. Guthe and W. Straßer, Real-time Decompression and Visualization of Animated Volume Data, IEEE Visualization
//! 2001, section 2, and beyond it. This crate's README.md specifies the stream and lists the differences.

pub mod coders;
pub mod decode;
mod encode;
mod passes;
pub mod quantiser;
mod reader;
pub mod settings;
pub mod stream;
pub mod transform;

use std::sync::Arc;

use cvr_core::codec::{
    Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Paper, Settings,
};
use cvr_core::container::EncodedVolume;

use settings::Options;

static INFO: CodecInfo = CodecInfo {
    id: "wavelet",
    summary: "wavelet transform of the whole volume, quantised and entropy-coded; or of blocks that decode on their own",
    stream_version: 1,
    decoded_by: &[DecodedBy::Passes, DecodedBy::Cpu],
    fetch_cell: false,
    paper: Some(Paper {
        authors: "S. Guthe, W. Straßer",
        title: "Real-time Decompression and Visualization of Animated Volume Data",
        venue: "IEEE Visualization, 2001",
    }),
    settings: settings::SETTINGS,
    methods: settings::METHODS,
};

/// The codec `wavelet`.
#[derive(Copy, Clone, Debug, Default)]
pub struct Wavelet;

/// The codec, as a registry takes it.
#[must_use]
pub fn codec() -> Arc<dyn Codec> {
    Arc::new(Wavelet)
}

impl Codec for Wavelet {
    fn info(&self) -> &CodecInfo {
        &INFO
    }

    /// The full resolution and one for each decomposition. Blocks have one.
    fn resolutions(&self, settings: &Settings) -> u8 {
        let [block, decompositions] =
            ["block", "decompositions"].map(|name| settings.integer(name).unwrap_or(0));
        if block > 0 { 1 } else { decompositions as u8 + 1 }
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        Ok(Box::new(encode::WaveletEncoder { options: Options::new(settings)? }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(reader::Reader::open(&volume)?))
    }
}
