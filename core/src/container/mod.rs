//! The encoded file: a safetensors file whose metadata hold one JSON [`Spec`].
//!
//! The spec holds the codec that wrote the tensors, the volume's layout, every parameter that decoding needs, and a
//! crc32c per tensor. Next to it stands a crc32c of the spec itself. A decoder needs nothing outside the file.

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

/// Why a container cannot be read or written. The message has the path, if there is one.
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
    /// The file is not a `cvr` container, or it is damaged. The message says what is wrong.
    #[error("{path}: {problem}")]
    Malformed {
        /// File.
        path: String,
        /// The problem, and the way out.
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
    /// A tensor has another type or length than its use requires.
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
