//! Why there is no shader.

/// A shader that cannot be generated. The message has file, line, column and a caret.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ShaderError(pub String);
