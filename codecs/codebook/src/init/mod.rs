//! The first codebook, which [`crate::lbg`] refines. One file for each way to begin.

pub mod pca;

use cvr_core::codec::{Cancelled, Progress};
use serde::{Deserialize, Serialize};

use crate::Vectors;

/// How the first codebook is made.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Initial {
    /// Cells cut across their principal axis: [`pca`].
    #[default]
    Pca,
}

impl Initial {
    /// At most `size` vectors, one after the other, before they are quantised.
    ///
    /// # Errors
    /// When `run` was cancelled.
    ///
    /// # Panics
    /// When there are no vectors.
    pub fn codewords(
        self,
        vectors: &Vectors,
        size: usize,
        run: &Progress<'_>,
    ) -> Result<Vec<f64>, Cancelled> {
        match self {
            Self::Pca => pca::split(vectors, size, run),
        }
    }
}
