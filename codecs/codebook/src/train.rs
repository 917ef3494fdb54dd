//! From training vectors to a codebook, in one call.

use cvr_core::codec::{Cancelled, Progress};

use crate::lbg::{Stop, Trained, refine};
use crate::{Codebook, Initial, Quantiser, Vectors};

/// How a codebook is trained.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Training {
    /// Codewords wanted; fewer come out where there are fewer distinct vectors, or codewords.
    pub size: usize,
    /// How codewords are stored.
    pub quantiser: Quantiser,
    /// The first codebook.
    pub initial: Initial,
    /// What chance decides: see [`Initial`].
    pub seed: u64,
    /// When refinement stops.
    pub stop: Stop,
}

/// Trains a codebook. Equal vectors are merged first.
///
/// # Errors
/// When `run` was cancelled.
///
/// # Panics
/// When there are no vectors, or `size` is zero.
pub fn train(vectors: &Vectors, training: &Training, run: &Progress<'_>) -> Result<Trained, Cancelled> {
    assert!(training.size > 0, "a codebook needs a codeword");
    let vectors = vectors.merged();
    let first = training.initial.codewords(&vectors, training.size, training.seed, run)?;
    let first = Codebook::nearest_to(&first, vectors.dimension(), training.quantiser);
    refine(&vectors, first, training.size, training.stop, run)
}
