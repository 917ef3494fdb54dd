//! Adaptive probabilities of bits.

/// The probability of a bit, learnt from the bits before it: the mean of a fast and a slow estimate. Both begin as
/// running means.
#[derive(Copy, Clone, Debug)]
pub struct Adaptive {
    fast: u16,
    slow: u16,
    seen: u8,
}

/// Shifts at which estimates stop to slow down.
const FAST: u8 = 4;
const SLOW: u8 = 7;

impl Default for Adaptive {
    fn default() -> Self {
        Self { fast: 1 << 15, slow: 1 << 15, seen: 0 }
    }
}

impl Adaptive {
    /// Probability of a 0, in 65536ths, far enough from 0 and 1.
    #[inline]
    #[must_use]
    pub fn zero(self) -> u16 {
        let mean = (u32::from(self.fast) + u32::from(self.slow)) >> 1;
        mean.clamp(24, 65536 - 24) as u16
    }

    /// Learns from a bit.
    #[inline]
    pub fn learn(&mut self, bit: bool) {
        let target = if bit { 0 } else { u16::MAX };
        let shift = 1 + (8 - (self.seen.leading_zeros() as u8).min(8)).min(8);
        self.seen = self.seen.saturating_add(1);
        let towards = |p: &mut u16, shift: u8| {
            let step = (i32::from(target) - i32::from(*p)) >> shift;
            *p = (i32::from(*p) + step) as u16;
        };
        towards(&mut self.fast, shift.min(FAST));
        towards(&mut self.slow, shift.min(SLOW));
    }
}
