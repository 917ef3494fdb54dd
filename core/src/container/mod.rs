//! The encoded file: a safetensors file whose metadata hold one JSON [`Spec`].
//!
//! The spec says which codec wrote the tensors, the volume's layout, every parameter that decoding needs, and a
//! crc32c per tensor; a crc32c over the spec itself stands beside it. Nothing outside the file is needed.

mod header;
mod read;
mod spec;
#[cfg(test)]
mod tests;
mod write;

pub use header::RESERVED;
pub use read::{EncodedVolume, Tensor};
pub use spec::{Element, Spec, TensorSpec};
pub use write::{ContainerWriter, StreamWriter, Written};

use crate::memory::OutOfMemory;

/// Why a container cannot be read or written. The path stands in the message where there is one.
#[derive(Debug, thiserror::Error)]
pub enum ContainerError {
    /// Reading or writing failed.
    #[error("{path}: {source}")]
    Io {
        /// File.
        path: String,
        /// Cause.
        source: std::io::Error,
    },
    /// The file is not a container of ours, or damaged; the message says what is wrong.
    #[error("{path}: {problem}")]
    Malformed {
        /// File.
        path: String,
        /// What is wrong, and the way out.
        problem: String,
    },
    /// There is no memory for its tensors.
    #[error("{path}: {source}")]
    Memory {
        /// File.
        path: String,
        /// What needs how much.
        source: OutOfMemory,
    },
    /// The decoder asked for a tensor that is not there.
    #[error("tensor `{name}` is missing; the stream holds: {known}")]
    MissingTensor {
        /// Name asked for.
        name: String,
        /// Names present.
        known: String,
    },
    /// A tensor is of another type or length than its use demands.
    #[error("tensor `{name}`: {problem}")]
    Tensor {
        /// Tensor.
        name: String,
        /// What is wrong.
        problem: String,
    },
    /// Codec parameters do not parse.
    #[error("parameters of codec `{codec}`: {problem}")]
    Parameters {
        /// Codec id.
        codec: String,
        /// What is wrong.
        problem: String,
    },
}
