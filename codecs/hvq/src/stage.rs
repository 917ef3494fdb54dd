//! The two stages of differences: the levels that a code adds, and the positions of codewords.

use cvr_codebook::{Quantiser, index_bits};
use serde::{Deserialize, Serialize};

use crate::MOST_CODEWORDS;

/// Storage of the codewords of one stage: a code adds `(code − zero) · step` levels.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageParameters {
    /// Number of codewords of each table: one table for all frames, or one per frame.
    pub tables: Vec<u32>,
    /// The code that adds nothing.
    pub zero: u32,
    /// Levels per code.
    pub step: u32,
}

/// Most levels that a code may add. A stream with more is refused. It is far more than any encoder uses, and sums of
/// three stay within 32 bits.
const MOST_LEVELS: u64 = 1 << 24;

impl StageParameters {
    /// The finest step, with its zero, so that codes of `bits` bits cover `low` to `high` levels within half a step.
    /// `low` is at most 0 and `high` at least 0.
    pub fn reaching(low: f64, high: f64, bits: u32) -> Self {
        let most = (1_u32 << bits) - 1;
        let codes = |levels: f64, step: u32| (levels / f64::from(step)).round() as u32;
        let fits = |step: &u32| codes(-low, *step) + codes(high, *step) <= most;
        // Both ends are rounded, so the step may need to be one larger than the range suggests.
        let least = (((high - low) / f64::from(most)).floor() as u32).max(1);
        let step = (least..).find(fits).unwrap_or(least);
        let (below, above) = (codes(-low, step), codes(high, step));
        Self { tables: Vec::new(), zero: below + (most - below - above) / 2, step }
    }

    /// Whether these parameters are valid for codes of `bits` bits.
    pub fn is_sound(&self, bits: u32, frames: u32) -> bool {
        let most = (1_u64 << bits) - 1;
        (self.tables.len() == 1 || self.tables.len() == frames as usize)
            && self.tables.iter().all(|size| (1..=MOST_CODEWORDS).contains(size))
            && u64::from(self.zero) <= most
            && self.step > 0
            && u64::from(self.step) * most <= MOST_LEVELS
    }

    /// The same as a quantiser whose values are levels. `None` if the parameters are invalid.
    pub fn quantiser(&self, bits: u32) -> Option<Quantiser> {
        let (zero, step) = (self.zero as f32, self.step as f32);
        // 0 − 0 is 0, and not −0.
        Quantiser::of_stream(bits, 0.0 - zero * step, step)
    }

    /// Codewords of the largest table.
    pub fn largest(&self) -> u32 {
        self.tables.iter().copied().max().unwrap_or(1)
    }

    /// Bits of an index: as many as the largest table needs.
    pub fn index_bits(&self) -> u32 {
        index_bits(self.largest() as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_reach_both_ends_and_nothing_is_exactly_zero() {
        for (low, high, bits) in [
            (0.0, 0.0, 8),
            (-255.0, 255.0, 8),
            (-127.4, 127.6, 8),
            (-3.0, 900.5, 8),
            (-65535.0, 65535.0, 8),
            (-65535.0, 65535.0, 16),
            (-0.25, 0.0, 16),
        ] {
            let stage = StageParameters { tables: vec![2], ..StageParameters::reaching(low, high, bits) };
            assert!(stage.is_sound(bits, 1), "{stage:?}");
            let quantiser = stage.quantiser(bits).unwrap();
            assert_eq!(quantiser.value(stage.zero), 0.0);
            let reached = |v: f64| f64::from(quantiser.value(quantiser.code(v).into()));
            let half = f64::from(stage.step) / 2.0;
            assert!((reached(low) - low).abs() <= half && (reached(high) - high).abs() <= half, "{stage:?}");
            let coarser = (high - low) / f64::from((1_u32 << bits) - 2) + 1.0;
            assert!(f64::from(stage.step) <= coarser, "{stage:?} for {low} to {high}");
        }
    }

    #[test]
    fn sums_that_leave_32_bits_are_not_sound() {
        let stage = |zero, step| StageParameters { tables: vec![2], zero, step };
        assert!(stage(255, 1).is_sound(8, 1));
        assert!(!stage(256, 1).is_sound(8, 1));
        assert!(!stage(0, 0).is_sound(8, 1));
        assert!(!stage(0, 1 << 9).is_sound(16, 1));
        assert!(!stage(0, u32::MAX).is_sound(8, 1));
    }
}
