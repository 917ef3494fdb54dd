//! White noise: every voxel is an independent number, uniform over 2^24 values in 0..1. No codec can compress it. Codes
//! and codewords trained on it are random.

use super::Signal;
use super::turbulence::mix;

pub(super) struct WhiteNoise {
    key: u64,
}

impl WhiteNoise {
    /// The seed is mixed first: two seeds that differ in one bit have nothing in common.
    pub const fn new(seed: u64) -> Self {
        Self { key: mix(seed) }
    }
}

impl Signal for WhiteNoise {
    fn fill_row(&self, y: u32, z: u32, row: &mut [f64]) {
        for (v, x) in row.iter_mut().zip(0_u64..) {
            let hash = [x, y.into(), z.into()].into_iter().fold(self.key, |h, c| mix(h ^ c));
            *v = (hash >> 40) as f64 / f64::from((1_u32 << 24) - 1);
        }
    }
}
