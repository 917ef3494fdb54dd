//! The uncompressed codec: samples in their own type, in 8 bits, or in half precision.
//!
//! It is the baseline of every comparison. This crate's README.md specifies the stream.

pub mod decode;
mod encode;
mod form;
mod reader;

use std::sync::Arc;

use cvr_core::codec::{
    Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Setting, SettingKind, Settings,
};
use cvr_core::container::EncodedVolume;

pub use form::{Bits, Form, Kind};

/// Name of the one tensor and of the one shader resource.
const SAMPLES: &str = "samples";

static INFO: CodecInfo = CodecInfo {
    id: "raw",
    summary: "uncompressed samples: native, 8 bits over the value range, or half precision",
    stream_version: 1,
    decoded_by: &[DecodedBy::Shader, DecodedBy::Cpu],
    fetch_cell: false,
    paper: None,
    settings: &[Setting {
        name: "bits",
        doc: "native = the sample's own type, lossless; 8 = 8 bits over the volume's value range; half = IEEE half",
        kind: SettingKind::Choice(&["native", "8", "half"]),
        default: "native",
    }],
    methods: &[],
};

/// The codec `raw`.
#[derive(Copy, Clone, Debug, Default)]
pub struct Raw;

/// The codec, as a registry takes it.
#[must_use]
pub fn codec() -> Arc<dyn Codec> {
    Arc::new(Raw)
}

impl Codec for Raw {
    fn info(&self) -> &CodecInfo {
        &INFO
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        let bits = settings.text("bits")?;
        let bits = Bits::from_name(bits).ok_or_else(|| ConfigError::Incomplete("bits".to_owned()))?;
        Ok(Box::new(encode::RawEncoder { bits }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(reader::Reader::open(&volume)?))
    }
}
