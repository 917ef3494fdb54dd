//! From training vectors to a codebook, in one call.

use cvr_core::codec::{Cancelled, Progress};

use crate::lbg::{Stop, Trained, refine};
use crate::{Codebook, Initial, Quantiser, Vectors};

/// How a codebook is trained.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Training {
    /// Number of codewords. Fewer result if there are fewer distinct vectors or codewords.
    pub size: usize,
    /// How codewords are stored.
    pub quantiser: Quantiser,
    /// The first codebook.
    pub initial: Initial,
    /// Seed of random choices: see [`Initial`].
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
    train_over(vectors, training, |_| training.quantiser, run)
}

/// As [`train`], where the first codewords, before they are stored, decide how codewords are stored.
///
/// # Errors
/// When `run` was cancelled.
///
/// # Panics
/// When there are no vectors, or `size` is zero.
pub fn train_over(
    vectors: &Vectors,
    training: &Training,
    quantiser: impl FnOnce(&[f64]) -> Quantiser,
    run: &Progress<'_>,
) -> Result<Trained, Cancelled> {
    assert!(training.size > 0, "a codebook needs a codeword");
    let vectors = vectors.merged();
    let first = training.initial.begin(&vectors, training.size, training.seed, run)?;
    let quantiser = quantiser(&first.codewords);
    let (codebook, places) = Codebook::placed(&first.codewords, vectors.dimension(), quantiser);
    let cells = first.cells.map(|cells| cells.into_iter().map(|k| places[k as usize]).collect::<Vec<u32>>());
    // Members of a cell that are adjacent are read faster in every round.
    let Some(mut cells) = cells else {
        return refine(&vectors, codebook, None, training.size, training.stop, run);
    };
    let mut order: Vec<u32> = (0..cells.len() as u32).collect();
    order.sort_by_key(|i| cells[*i as usize]);
    cells.sort_unstable();
    refine(&vectors.ordered(&order), codebook, Some(&cells), training.size, training.stop, run)
}
