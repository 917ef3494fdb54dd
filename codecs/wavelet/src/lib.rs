//! Wavelets: the transform of whole volumes, quantised and entropy-coded, and blocks that a shader decodes.
//!
//! After S. Guthe and W. Straßer, Real-time Decompression and Visualization of Animated Volume Data, IEEE Visualization
//! 2001, section 2, and beyond it. This crate's README.md specifies the stream and lists the differences.

pub mod blocks;
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
    Block, Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Paper, Settings,
    check_stream,
};
use cvr_core::container::EncodedVolume;
use serde::Deserialize;

use encode::{BlockEncoder, WaveletEncoder};
use reader::Reader;
use settings::Options;
use stream::parameters::Mode;

static INFO: CodecInfo = CodecInfo {
    id: "wavelet",
    summary: "wavelet transform of the whole volume, quantised and entropy-coded; or of blocks that decode on their own",
    stream_version: 1,
    decoded_by: &[DecodedBy::Shader, DecodedBy::Passes, DecodedBy::Cpu],
    fetch_cell: true,
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

    /// Whole volumes are decoded by passes, blocks by a snippet.
    fn decoded_by(&self, settings: &Settings) -> &'static [DecodedBy] {
        if is_blocks(settings) {
            &[DecodedBy::Shader, DecodedBy::Cpu]
        } else {
            &[DecodedBy::Passes, DecodedBy::Cpu]
        }
    }

    /// The full resolution and one for each decomposition. Blocks have one.
    fn resolutions(&self, settings: &Settings) -> u8 {
        if is_blocks(settings) { 1 } else { settings.integer("decompositions").unwrap_or(0) as u8 + 1 }
    }

    fn block(&self, settings: &Settings) -> Option<Block> {
        let edge = settings.integer("block").ok().filter(|edge| *edge > 0)?;
        edge.to_string().parse().ok()
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        let options = Options::new(settings)?;
        Ok(if options.block > 0 {
            Box::new(BlockEncoder(options))
        } else {
            Box::new(WaveletEncoder { options })
        })
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        check_stream(&volume, &INFO)?;
        Ok(match volume.parameters::<Stored>()?.mode {
            Mode::Volume => Box::new(Reader::open(&volume)?),
            Mode::Blocks => Box::new(blocks::Reader::open(&volume)?),
        })
    }
}

/// Whether these settings ask for blocks.
fn is_blocks(settings: &Settings) -> bool {
    settings.integer("block").is_ok_and(|edge| edge > 0)
}

/// What tells the streams of whole volumes and of blocks apart.
#[derive(Deserialize)]
struct Stored {
    mode: Mode,
}
