//! Ways to escape blocks that may pay.

use crate::choice::{Candidate, escape_bits};
use crate::{MOST_BITS, VOXELS};

/// One more bit for each voxel is not tried where what is left is worth less than this part of it. Limit.
pub(crate) const WORTH: f64 = 1.0;

/// Ways to escape the blocks of one plane.
#[derive(Clone, Debug, Default)]
pub struct Ways {
    candidates: Vec<Candidate>,
    ends: Vec<u32>,
}

impl Ways {
    /// Those of a block, by number of codes before them.
    ///
    /// # Panics
    /// When there is no such block.
    #[must_use]
    #[inline]
    pub fn of(&self, block: usize) -> &[Candidate] {
        let begin = if block == 0 { 0 } else { self.ends[block - 1] };
        &self.candidates[begin as usize..self.ends[block] as usize]
    }

    /// Those of the next block.
    pub fn push(&mut self, candidates: impl IntoIterator<Item = Candidate>) {
        self.candidates.extend(candidates);
        self.ends.push(self.candidates.len() as u32);
    }

    /// Those of the blocks of `other` behind these.
    pub fn append(&mut self, other: &Self) {
        let begun = self.candidates.len() as u32;
        self.candidates.extend(&other.candidates);
        self.ends.extend(other.ends.iter().map(|end| begun + end));
    }
}

/// What bits cost where ways are sought.
#[derive(Copy, Clone, Debug)]
pub struct Prices {
    /// Squared error that a bit is worth at least.
    pub bit: f64,
    /// Bits of a code.
    pub width: f64,
    /// Parts of an escape.
    pub parts: u32,
}

impl Prices {
    /// Values of a block.
    fn values(self) -> f64 {
        VOXELS as f64 * f64::from(self.parts)
    }

    /// Ways that may pay at such a price or above it: behind the mean alone, and behind the codes that leave what takes the fewest
    /// bits. Half a bit for each voxel halves the error of a block. `errors[n]` is what `n` codes leave, and `behind(n)` yields the
    /// squared error of an escape behind them, by its bits of a voxel.
    pub fn ways<E: FnMut(u32) -> f32>(
        self,
        errors: &[f32],
        behind: impl Fn(usize) -> E,
        mut found: impl FnMut(Candidate),
    ) {
        let cost = |n: usize| f64::from(errors[n]) + self.bit * self.width * n as f64;
        let least = (0..errors.len()).map(cost).fold(f64::INFINITY, f64::min);
        if least <= self.bit * f64::from(escape_bits(1, self.parts)) {
            return;
        }
        let bits = |n: usize| 0.5 * self.values() * f64::from(errors[n]).log2() + self.width * n as f64;
        let count = (0..errors.len()).min_by(|a, b| bits(*a).total_cmp(&bits(*b))).unwrap_or(0);
        for count in if count == 0 { vec![0] } else { vec![0, count] } {
            let mut escape = behind(count);
            let mut before = f64::from(errors[count]);
            for bits in 1..=MOST_BITS {
                if before <= self.bit * WORTH * self.values() {
                    break;
                }
                let error = escape(bits);
                if f64::from(error) < before {
                    found(Candidate { codes: count as u8, bits: bits as u8, error });
                    before = error.into();
                }
            }
        }
    }
}
