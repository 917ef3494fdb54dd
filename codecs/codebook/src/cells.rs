//! Which vectors are nearest to each codeword.

use crate::wide::wide;
use crate::{Nearest, Vectors};

/// The vectors of each codeword.
#[derive(Clone, Debug)]
pub struct Cells {
    /// Indices of vectors, ascending within a cell, cell after cell.
    order: Vec<u32>,
    /// Start of each cell, and the end of the last.
    starts: Vec<usize>,
}

impl Cells {
    /// Of `size` codewords.
    pub(crate) fn new(nearest: &[Nearest], size: usize) -> Self {
        Self::of(nearest.iter().map(|n| n.index), size)
    }

    /// Of `size` codewords, by the codeword of each vector.
    ///
    /// # Panics
    /// When there is no such codeword.
    #[must_use]
    pub fn of(codewords: impl Iterator<Item = u32> + Clone, size: usize) -> Self {
        let mut starts = vec![0; size + 1];
        codewords.clone().for_each(|k| starts[k as usize + 1] += 1);
        for k in 0..size {
            starts[k + 1] += starts[k];
        }
        let mut places = starts.clone();
        let mut order = vec![0; starts[size]];
        for (i, k) in codewords.enumerate() {
            let place = &mut places[k as usize];
            order[*place] = i as u32;
            *place += 1;
        }
        Self { order, starts }
    }

    /// Numbers of the vectors of codeword `k`, ascending.
    ///
    /// # Panics
    /// When there is no such codeword.
    #[must_use]
    pub fn members(&self, k: usize) -> &[u32] {
        &self.order[self.starts[k]..self.starts[k + 1]]
    }

    /// Weighted squared distance of the members.
    pub(crate) fn distortion(&self, k: usize, vectors: &Vectors, nearest: &[Nearest]) -> f64 {
        self.members(k).iter().map(|i| vectors.weight(*i as usize) * nearest[*i as usize].distance).sum()
    }

    /// Weighted mean of a cell that has members.
    ///
    /// # Panics
    /// When there is no such codeword.
    #[must_use]
    pub fn mean(&self, k: usize, vectors: &Vectors) -> Vec<f64> {
        wide(|| {
            let mut sums = vec![0.0; vectors.dimension()];
            let mut total = 0.0;
            for &i in self.members(k) {
                let weight = vectors.weight(i as usize);
                total += weight;
                for (sum, x) in sums.iter_mut().zip(vectors.vector(i as usize)) {
                    *sum += weight * f64::from(*x);
                }
            }
            sums.iter_mut().for_each(|sum| *sum /= total);
            sums
        })
    }

    /// The member that adds most to the distortion, the first of equals.
    pub(crate) fn worst(&self, k: usize, vectors: &Vectors, nearest: &[Nearest]) -> Option<usize> {
        let share = |i: &u32| vectors.weight(*i as usize) * nearest[*i as usize].distance;
        let worst = self.members(k).iter().rev().max_by(|a, b| share(a).total_cmp(&share(b)));
        worst.map(|i| *i as usize)
    }
}
