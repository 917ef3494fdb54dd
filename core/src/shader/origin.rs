//! Where each line of a generated shader comes from, and errors that say so.

use std::ops::Range;

/// Who wrote a part of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A file: a template, or a codec's snippet.
    File {
        /// Path as its author knows it.
        file: String,
        /// Whether it is the codec's.
        snippet: bool,
    },
    /// The generator.
    Generated {
        /// What for.
        purpose: String,
    },
}

/// A part of the generated text that was copied whole from one origin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Bytes in the generated text.
    pub range: Range<usize>,
    /// Where they come from.
    pub origin: Origin,
}

/// A shader that cannot be made; the message carries file, line, column and a caret.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ShaderError(pub String);
