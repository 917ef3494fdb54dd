//! Models of a bit whose probability is known, and of bits about which nothing is known.

use std::{borrow::Borrow, num::NonZeroU32};

use constriction::stream::model::{DecoderModel, EncoderModel, EntropyModel};

/// Bits of the probability of a bit.
pub const BIT_PRECISION: usize = 16;

/// A bit that is 0 with a probability of this many 65536ths.
#[derive(Copy, Clone, Debug)]
pub struct Bit(pub u16);

impl Bit {
    #[inline]
    fn interval(&self, bit: bool) -> (u32, Option<NonZeroU32>) {
        let zero = u32::from(self.0);
        if bit { (zero, NonZeroU32::new((1 << BIT_PRECISION) - zero)) } else { (0, NonZeroU32::new(zero)) }
    }
}

impl EntropyModel<BIT_PRECISION> for Bit {
    type Symbol = bool;
    type Probability = u32;
}

impl EncoderModel<BIT_PRECISION> for Bit {
    #[inline]
    fn left_cumulative_and_probability(&self, bit: impl Borrow<bool>) -> Option<(u32, NonZeroU32)> {
        let (start, length) = self.interval(*bit.borrow());
        Some((start, length?))
    }
}

impl DecoderModel<BIT_PRECISION> for Bit {
    #[inline]
    fn quantile_function(&self, quantile: u32) -> (bool, u32, NonZeroU32) {
        let bit = quantile >= u32::from(self.0);
        let (start, length) = self.interval(bit);
        (bit, start, length.unwrap_or(NonZeroU32::MIN))
    }
}

/// A number of this many bits, 1 to 16, all equally probable.
#[derive(Copy, Clone, Debug)]
pub struct Uniform(pub u32);

impl Uniform {
    /// All its bits set.
    #[inline]
    #[must_use]
    pub const fn mask(self) -> u32 {
        (1 << self.0) - 1
    }

    #[inline]
    fn interval(self, number: u32) -> (u32, NonZeroU32) {
        let shift = BIT_PRECISION as u32 - self.0;
        (number << shift, NonZeroU32::new(1 << shift).unwrap_or(NonZeroU32::MIN))
    }
}

impl EntropyModel<BIT_PRECISION> for Uniform {
    type Symbol = u32;
    type Probability = u32;
}

impl EncoderModel<BIT_PRECISION> for Uniform {
    #[inline]
    fn left_cumulative_and_probability(&self, number: impl Borrow<u32>) -> Option<(u32, NonZeroU32)> {
        Some(self.interval(*number.borrow()))
    }
}

impl DecoderModel<BIT_PRECISION> for Uniform {
    #[inline]
    fn quantile_function(&self, quantile: u32) -> (u32, u32, NonZeroU32) {
        let number = quantile >> (BIT_PRECISION as u32 - self.0);
        let (start, length) = self.interval(number);
        (number, start, length)
    }
}
