//! What is expected of coding a block directly, where it is not tried: in trials on few blocks.

use crate::choice::escape_bits;
use crate::ways::WORTH;
use crate::{MOST_BITS, VOXELS};

/// Part of a block's error that is expected to be left by a quantiser of 0, 1, … bits: between normal and Laplacian
/// distributions (Max 1960).
const LEFT: [f64; 5] = [1.0, 0.42, 0.15, 0.05, 0.016];
/// And by each further bit.
const LEFT_BEYOND: f64 = 0.3;

/// What coding blocks directly costs and leaves, as is expected.
#[derive(Copy, Clone, Debug)]
pub struct Expected {
    /// Squared error of a block below which rounding to integers leaves none; none where blocks are not coded directly.
    exact_below: Option<f64>,
    /// Parts of an escape.
    parts: u32,
}

/// A block that is coded directly: what it leaves, and its bits, as expected.
#[derive(Copy, Clone, Debug)]
pub struct Direct {
    /// Squared error.
    pub error: f64,
    /// Bits of the escape.
    pub bits: f64,
    /// Error and what the bits cost.
    pub cost: f64,
}

impl Expected {
    /// For integers that are `unit` units of sums apart, or for floats. An escape has so many parts.
    #[must_use]
    pub fn of(unit: Option<f64>, parts: u32) -> Self {
        let values = VOXELS as f64 * f64::from(parts);
        Self { exact_below: Some(unit.map_or(0.0, |unit| values * unit * unit / 12.0)), parts }
    }

    /// Nothing is coded directly.
    #[must_use]
    pub const fn never() -> Self {
        Self { exact_below: None, parts: 1 }
    }

    /// The cheapest way to code directly what codes leave, at a price of a bit; none where nothing is cheaper than the error.
    #[must_use]
    pub fn direct(&self, error: f64, price: f64) -> Option<Direct> {
        let taken = |bits: u32| f64::from(escape_bits(bits, self.parts));
        let exact_below = self.exact_below.filter(|_| error > price * taken(1))?;
        let mut best: Option<Direct> = None;
        let mut part = 1.0;
        for bits in 1..=MOST_BITS {
            part = LEFT.get(bits as usize).copied().unwrap_or(part * LEFT_BEYOND);
            let left = if error * part < exact_below { 0.0 } else { error * part };
            let cost = left + price * taken(bits);
            if best.is_none_or(|b| cost < b.cost) {
                best = Some(Direct { error: left, bits: taken(bits), cost });
            }
            if left <= price * WORTH * VOXELS as f64 * f64::from(self.parts) {
                break;
            }
        }
        best.filter(|b| b.cost < error)
    }

    /// By number of codebooks: behind how many codes what is left takes the fewest bits.
    #[must_use]
    pub fn behind(errors: &[f64], width: f64) -> Vec<u8> {
        let bits = |n: usize| 0.5 * VOXELS as f64 * errors[n].max(1e-9).log2() + width * n as f64;
        let (mut least, mut best) = (f64::INFINITY, 0);
        let of_count = |n: usize| {
            if bits(n) < least {
                (least, best) = (bits(n), n as u8);
            }
            best
        };
        (0..errors.len()).map(of_count).collect()
    }
}
