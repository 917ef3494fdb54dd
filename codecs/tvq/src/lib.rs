//! Transform vector quantisation: a mean per block, and the sum of one codeword from each of a few codebooks.
//!
//! After N. Fout and K.-L. Ma, IEEE Transactions on Visualization and Computer Graphics 13 (6), 2007. This crate's
//! README.md specifies the stream and lists the differences from the paper.

pub mod decode;
mod encode;
mod settings;
mod stream;

use std::sync::Arc;

use cvr_core::codec::{
    Block, Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Paper, Settings,
};
use cvr_core::container::EncodedVolume;

pub use stream::geometry::{Geometry, Parameters, Payload};

static INFO: CodecInfo = CodecInfo {
    id: "tvq",
    summary: "a mean per block, and a sum of codewords: inverse transforms by class and partition",
    stream_version: 3,
    decoded_by: &[DecodedBy::Shader, DecodedBy::Cpu],
    fetch_cell: true,
    paper: Some(Paper {
        authors: "N. Fout, K.-L. Ma",
        title: "Transform Coding for Hardware-accelerated Volume Rendering",
        venue: "IEEE Transactions on Visualization and Computer Graphics 13 (6), 2007",
    }),
    settings: settings::SETTINGS,
    methods: settings::METHODS,
};

/// Parts of the encoder for `examples/budget.rs`. Not a public interface.
#[doc(hidden)]
pub mod inside {
    use cvr_core::codec::{ConfigError, Encoder, Settings};

    pub use crate::encode::train::classify::{energies, zones_of};
    pub use crate::encode::train::transform::{Basis, Transform};
    pub use crate::stream::table::Partition;

    /// An encoder with codebooks of these sizes for the payload `fixed`, at any cost.
    ///
    /// # Errors
    /// When a setting is missing.
    pub fn encoder_of_sizes(settings: &Settings, sizes: [usize; 3]) -> Result<Box<dyn Encoder>, ConfigError> {
        let options =
            crate::settings::Options { sizes: Some(sizes), ..crate::settings::Options::of(settings)? };
        Ok(Box::new(crate::encode::TvqEncoder { options }))
    }
}

/// The codec `tvq`.
#[derive(Copy, Clone, Debug, Default)]
pub struct Tvq;

/// The codec, as a registry takes it.
#[must_use]
pub fn codec() -> Arc<dyn Codec> {
    Arc::new(Tvq)
}

impl Codec for Tvq {
    fn info(&self) -> &CodecInfo {
        &INFO
    }

    /// The means, and each partition.
    fn stages(&self, _settings: &Settings) -> u8 {
        4
    }

    /// Blocks of 4³ voxels.
    fn block(&self, _settings: &Settings) -> Option<Block> {
        Some(stream::geometry::block())
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        Ok(Box::new(encode::TvqEncoder { options: settings::Options::of(settings)? }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(decode::reader::Reader::open(&volume)?))
    }
}
