//! Coefficients to bits: negabinary numbers, plane by plane, with group tests above the highest coefficient reached.
//!
//! Lindstrom 2014, section 4.4, in the form of zfp's documentation (*Algorithm*, steps 5 to 8).

use crate::geometry::HEADER_BITS;
use crate::lift::coefficients;

/// The bits of the odd powers of −2.
pub const NEGABINARY: u32 = 0xaaaa_aaaa;
/// Values are stored as multiples of 2^(exponent − `UNITS`), so they have two bits less than their integers.
const UNITS: i32 = 30;
/// Bias of the stored exponent.
const BIAS: i32 = 127;
/// Words of a block with the most bits.
pub const MOST_WORDS: usize = 64;

/// The bits of one block, starting at the least significant bit of the first word.
#[derive(Clone, Debug)]
pub struct BlockBits {
    words: [u32; MOST_WORDS],
    at: u32,
    end: u32,
}

impl BlockBits {
    /// Codes 64 finite values, x fastest, into at most `block_bits` bits. Unused bits are 0.
    #[must_use]
    pub fn of(values: &[f32; 64], block_bits: u32) -> Self {
        let mut bits = Self { words: [0; MOST_WORDS], at: 0, end: block_bits };
        let exponent = stored_exponent(values);
        if exponent > 0 {
            bits.put(1, 1);
            bits.put(u64::from(exponent), HEADER_BITS - 1);
            let coefficients = coefficients(&integers(values, exponent));
            bits.planes(&coefficients.map(|c| (c as u32).wrapping_add(NEGABINARY) ^ NEGABINARY));
        }
        bits
    }

    /// The words that hold the bits.
    #[must_use]
    pub fn words(&self) -> &[u32] {
        &self.words[..self.end.div_ceil(32) as usize]
    }

    const fn left(&self) -> u32 {
        self.end - self.at
    }

    /// Appends the lowest `count` bits. There must be room for all of them.
    fn put(&mut self, bits: u64, count: u32) {
        let mut bits = if count < 64 { bits & ((1 << count) - 1) } else { bits };
        let mut count = count;
        while count > 0 {
            let (word, shift) = ((self.at / 32) as usize, self.at % 32);
            let part = count.min(32 - shift);
            self.words[word] |= (bits as u32) << shift;
            bits >>= part;
            self.at += part;
            count -= part;
        }
    }

    /// Writes planes from the highest down while there is room. Of each plane it writes the bits of the coefficients
    /// that earlier planes have reached. For the others it writes group tests: whether there is another set bit, then
    /// the zeros up to it.
    fn planes(&mut self, coefficients: &[u32; 64]) {
        let mut reached = 0;
        for plane in (0..32).rev() {
            let bit = |(i, c): (usize, &u32)| u64::from(c >> plane & 1) << i;
            let all: u64 = coefficients.iter().enumerate().map(bit).fold(0, |all, bit| all | bit);
            self.put(all, reached.min(self.left()));
            while self.left() > 0 && reached < 64 {
                let more = all >> reached;
                self.put(u64::from(more != 0), 1);
                if more == 0 {
                    break;
                }
                // For the last coefficient the group test is enough.
                let zeros = more.trailing_zeros();
                let last = 63 - reached;
                let room = self.left().min(last);
                // The zeros and the bit that ends them.
                self.put(1 << zeros, (zeros + 1).min(room));
                reached += 1 + zeros.min(room);
            }
            if self.left() == 0 {
                return;
            }
        }
    }
}

/// Stored exponent of the power of two above all magnitudes. 0 if all values are 0.
fn stored_exponent(values: &[f32; 64]) -> u32 {
    let largest = values.iter().fold(0_u32, |largest, v| largest.max(v.abs().to_bits()));
    // 1.m · 2^e is below 2^(e + 1). A subnormal counts as 0; no source holds one.
    match largest >> 23 {
        0 => 0,
        biased => biased + 1,
    }
}

/// The values as multiples of 2^(exponent − 30), truncated.
fn integers(values: &[f32; 64], stored: u32) -> [i32; 64] {
    let power = UNITS + BIAS - stored as i32;
    let units = f64::from_bits(((power + 1023) as u64) << 52);
    values.map(|v| (f64::from(v) * units) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_takes_no_bits() {
        let bits = BlockBits::of(&[0.0; 64], 64);
        assert_eq!((bits.at, bits.words()), (0, &[0, 0][..]));
    }

    #[test]
    fn the_exponent_stands_in_front() {
        for (value, exponent) in
            [(1.0, 128), (0.999, 127), (-255.0, 135), (f32::MAX, 255), (f32::MIN_POSITIVE, 2)]
        {
            let mut values = [0.0; 64];
            values[17] = value;
            let bits = BlockBits::of(&values, 9);
            assert_eq!((bits.at, bits.words()[0]), (9, 1 | exponent << 1), "{value}");
        }
    }

    #[test]
    fn no_block_takes_more_than_its_bits() {
        let values: [f32; 64] = std::array::from_fn(|i| ((i * 2_654_435_761) % 1013) as f32 - 500.0);
        let all = BlockBits::of(&values, 2048);
        for bits in 9..2048 {
            let fewer = BlockBits::of(&values, bits);
            assert!(fewer.at <= bits);
            let prefix =
                |i: usize| all.words()[i / 32] >> (i % 32) & 1 == fewer.words()[i / 32] >> (i % 32) & 1;
            assert!((0..bits as usize).all(prefix), "{bits} bits are no prefix");
        }
    }
}
