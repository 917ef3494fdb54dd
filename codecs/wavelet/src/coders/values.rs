//! Values of a region in an adaptive model.

use super::{
    counts::Counts,
    fault::Fault,
    range::{Decoder, Encoder},
    symbols::{fold, signed, unfold},
};

/// Magnitudes below 2^10 have a symbol each. Beyond, there is one for all magnitudes of as many bits, whose lower bits
/// follow as they are. So a model is small, whatever the largest magnitude says. The paper's quantisers have at most
/// 511 steps.
const DIRECT_BITS: u32 = 10;

/// The largest magnitude that has a symbol of its own.
const DIRECT: u32 = (1 << DIRECT_BITS) - 1;

/// How often each value of a region has been coded.
#[derive(Clone, Debug)]
pub struct Values {
    counts: Counts,
    largest: u32,
}

/// Number of a magnitude's class, and how many of its bits follow. Class 0 is zero.
const fn class(magnitude: u32) -> (u32, u32) {
    if magnitude <= DIRECT {
        return (magnitude, 0);
    }
    let bits = magnitude.ilog2();
    (DIRECT + 1 + bits - DIRECT_BITS, bits)
}

impl Values {
    /// The values of a region with this largest magnitude, which is at least 1: zero, and each class with either sign.
    #[must_use]
    pub fn new(largest: u32) -> Self {
        debug_assert!(largest > 0, "a region of zeros has no values");
        let (classes, _) = class(largest);
        Self { counts: Counts::new(2 * classes as usize + 1), largest }
    }

    /// Writes zero.
    #[inline]
    pub fn encode_zero(&mut self, encoder: &mut Encoder) {
        encoder.symbol(0, &mut self.counts);
    }

    /// Writes a value other than 0. `not_zero`: the decoder knows that it is not.
    #[inline]
    pub fn encode(&mut self, value: i32, not_zero: bool, encoder: &mut Encoder) {
        let (class, bits) = class(value.unsigned_abs());
        let symbol = fold(class, value < 0) as usize;
        if not_zero {
            encoder.symbol_after_first(symbol, &mut self.counts);
        } else {
            encoder.symbol(symbol, &mut self.counts);
        }
        encoder.encode_bits(value.unsigned_abs(), bits);
    }

    /// Reads zero or a value. `not_zero`: it is not zero.
    ///
    /// # Errors
    /// The bytes are corrupt.
    #[inline]
    pub fn decode(&mut self, not_zero: bool, decoder: &mut Decoder<'_>) -> Result<i32, Fault> {
        let symbol = if not_zero {
            decoder.symbol_after_first(&mut self.counts)?
        } else {
            decoder.symbol(&mut self.counts)?
        };
        if symbol == 0 {
            return Ok(0);
        }
        let (mut magnitude, negative) = unfold(symbol as u32);
        if magnitude > DIRECT {
            // No class is beyond that of the largest magnitude, so there are 30 bits at most.
            let bits = magnitude - DIRECT - 1 + DIRECT_BITS;
            magnitude = 1 << bits | decoder.decode_bits(bits)?;
        }
        signed(magnitude, negative, self.largest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back() {
        let values = [1, -1, 1022, 1023, -1023, 1024, -1024, 2047, 2048, 1 << 30, -i32::MAX, i32::MAX];
        let (mut encoder, mut model) = (Encoder::new(), Values::new(i32::MAX as u32));
        for value in values {
            model.encode(value, true, &mut encoder);
            model.encode_zero(&mut encoder);
            model.encode(value, false, &mut encoder);
        }
        let bytes = encoder.finish();
        let (mut decoder, mut model) = (Decoder::new(&bytes).unwrap(), Values::new(i32::MAX as u32));
        for value in values {
            assert_eq!(model.decode(true, &mut decoder), Ok(value));
            assert_eq!(model.decode(false, &mut decoder), Ok(0));
            assert_eq!(model.decode(false, &mut decoder), Ok(value));
        }
        decoder.finish().unwrap();
    }

    #[test]
    fn the_largest_magnitude_bounds_the_model_and_the_values() {
        assert_eq!([1023, 1024, 2047, 2048].map(|m| class(m).0), [1023, 1024, 1024, 1025]);
        assert_eq!(class(i32::MAX as u32), (DIRECT + 21, 30));
        let (mut encoder, mut model) = (Encoder::new(), Values::new(2047));
        model.encode(2000, true, &mut encoder);
        let bytes = encoder.finish();
        let read = |largest| Values::new(largest).decode(true, &mut Decoder::new(&bytes).unwrap());
        assert_eq!(read(2000), Ok(2000));
        assert!(read(1999).is_err());
    }
}
