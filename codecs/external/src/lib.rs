//! Any compressor that runs as a command on raw files (SZ3, SPERR and others), measured like a codec.
//!
//! Measured are the rate of its files, its errors, its pictures and the time of its processes. No shader decodes it.
//! This crate's README.md documents placeholders, stream and trust.

mod command;
mod decoder;
mod encode;
mod output;
mod samples;
mod trust;

use std::sync::Arc;
use std::time::Duration;

use cvr_core::codec::{
    Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Setting, SettingKind, Settings,
};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::SampleType;

use command::Command;
use trust::Trust;

/// Name of the one tensor.
const STREAMS: &str = "streams";

/// Longest command.
const COMMAND: SettingKind = SettingKind::Text { max: 4096 };

static INFO: CodecInfo = CodecInfo {
    id: "external",
    summary: "any compressor that runs as a command on raw files; its `name` distinguishes it",
    stream_version: 1,
    decoded_by: &[DecodedBy::Cpu],
    fetch_cell: false,
    paper: None,
    settings: &[
        Setting {
            name: "name",
            doc: "what records and charts call it: letters, digits, `.`, `_` and `-`; empty for `external` alone",
            kind: SettingKind::Text { max: 32 },
            default: "",
        },
        Setting {
            name: "encode",
            doc: "command that reads the samples in {in} and writes the compressed file {out}; see the codec's README for \
                  {x}, {y}, {z}, {type} and {value}. No shell reads it: write sh -c '…' where one should",
            kind: COMMAND,
            default: "cp {in} {out}",
        },
        Setting {
            name: "decode",
            doc: "command that reads the compressed file {in} and writes the samples to {out}",
            kind: COMMAND,
            default: "cp {in} {out}",
        },
        Setting {
            name: "value",
            doc: "what stands for {value} in both commands: a rate, a tolerance; list several to sweep it",
            kind: SettingKind::Float { min: -1e9, max: 1e9 },
            default: "0.0",
        },
        Setting {
            name: "sample",
            doc: "type of the samples in the files, little-endian: the volume's own, or IEEE single precision",
            kind: SettingKind::Choice(&["native", "f32"]),
            default: "native",
        },
        Setting {
            name: "timeout_seconds",
            doc: "a command that runs longer, in seconds of wall time, is killed, and its cells fail",
            kind: SettingKind::Integer { min: 1, max: 86_400 },
            default: "600",
        },
    ],
    methods: &["sample"],
};

/// The codec `external`. It runs only commands that this process has configured or written: see [`Trust`].
#[derive(Debug, Default)]
struct External {
    trust: Arc<Trust>,
}

/// The codec, as a registry takes it.
#[must_use]
pub fn codec() -> Arc<dyn Codec> {
    Arc::new(External::default())
}

impl Codec for External {
    fn info(&self) -> &CodecInfo {
        &INFO
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        let name = settings.text("name")?;
        if !name.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c)) {
            let problem =
                format!("`name = \"{name}\"` of codec `external`: letters, digits, `.`, `_` and `-` only");
            return Err(ConfigError::Contradiction(problem));
        }
        let seconds = settings.integer("timeout_seconds")?;
        let timeout = Duration::from_secs(seconds.unsigned_abs());
        let value = settings.float("value")?;
        let command = |setting: &str| -> Result<Command, ConfigError> {
            Command::parse(settings.text(setting)?, value, timeout)
                .map_err(|e| ConfigError::Contradiction(format!("`{setting}` of codec `external`: {e}")))
        };
        Ok(Box::new(encode::ExternalEncoder {
            encode: command("encode")?,
            decode: command("decode")?,
            sample: (settings.text("sample")? == "f32").then_some(SampleType::F32),
            trust: self.trust.clone(),
        }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(decoder::ExternalDecoder::new(&volume, &self.trust)?))
    }
}
