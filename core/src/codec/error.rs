//! Errors of codecs, split by who is at fault: the configuration, the input, or the stream.

use crate::container::ContainerError;
use crate::memory::OutOfMemory;
use crate::volume::SourceError;

/// The settings are wrong. The user can correct them in the configuration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ConfigError {
    /// The codec or renderer has no such setting.
    #[error("{owner} has no setting `{name}`; it has: {known}")]
    UnknownSetting {
        /// Codec or renderer, in words.
        owner: String,
        /// The unknown name.
        name: String,
        /// Known names.
        known: String,
    },
    /// The value is not allowed.
    #[error("`{name} = {value}` of {owner}: expected {expected}")]
    Value {
        /// Codec or renderer, in words.
        owner: String,
        /// Setting.
        name: String,
        /// Value as written.
        value: String,
        /// What is allowed.
        expected: String,
    },
    /// Two settings exclude each other.
    #[error("{0}")]
    Contradiction(String),
    /// An encoder was asked for with settings that [`super::CodecInfo::complete`] has not seen.
    #[error("setting `{0}` is missing: complete the settings with the codec's defaults first")]
    Incomplete(String),
}

/// Encoding failed.
#[derive(Debug, thiserror::Error)]
pub enum EncodeError {
    /// The settings are wrong.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// This codec cannot encode such a volume. The message says what it can encode.
    #[error("{0}")]
    Unsupported(String),
    /// A process that the encoder starts failed.
    #[error("{0}")]
    Failed(String),
    /// Reading the input failed.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// Writing the stream failed.
    #[error(transparent)]
    Container(#[from] ContainerError),
    /// There is no memory for it.
    #[error(transparent)]
    Memory(#[from] OutOfMemory),
    /// The user asked to stop.
    #[error("encoding was cancelled")]
    Cancelled,
}

impl From<super::Cancelled> for EncodeError {
    fn from(_: super::Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Decoding failed. The stream is wrong, or it does not hold what was asked for.
#[derive(Debug, thiserror::Error)]
pub enum DecodeError {
    /// The container lacks a tensor, or a tensor has the wrong type.
    #[error(transparent)]
    Container(#[from] ContainerError),
    /// The stream contradicts itself.
    #[error("corrupt stream: {0}")]
    Corrupt(String),
    /// The stream was written by a later version of the codec.
    #[error("codec `{codec}` reads streams up to version {known}; this one has version {found}")]
    Version {
        /// Codec id.
        codec: String,
        /// Highest version this codec reads.
        known: u32,
        /// Version of the stream.
        found: u32,
    },
    /// A process that the decoder starts failed.
    #[error("{0}")]
    Failed(String),
    /// There is no memory for it.
    #[error(transparent)]
    Memory(#[from] OutOfMemory),
    /// The stream needs something that its reader has not allowed.
    #[error("{0}")]
    Refused(String),
    /// The brick lies outside the volume, or the level does not exist.
    #[error("no such brick: {0}")]
    NoSuchBrick(String),
    /// A frame that this one depends on was not handed in.
    #[error("frame {frame} needs the decoded frame {missing}")]
    MissingReference {
        /// The frame to decode.
        frame: u32,
        /// The frame that it needs.
        missing: u32,
    },
}
