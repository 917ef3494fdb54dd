//! Why nothing is drawn.

/// Why a renderer cannot draw a view.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// This renderer does not support the view.
    #[error("{0}")]
    Unsupported(String),
    /// The mirror could not read a voxel.
    #[error("reading voxels failed: {0}")]
    Voxels(String),
}
