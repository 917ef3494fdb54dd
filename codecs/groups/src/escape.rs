//! What is left of a block after its codes, coded directly: an escape.
//!
//! An escape has one part, or one for each channel. A part is a word with the low end (signed, bits 8 to 31) and the step (a
//! [`Scale`], bits 0 to 7), and 64 numbers of `bits` bits, voxels x fastest: `low + step · number`, in units of sums.

use crate::scale::Scale;
use crate::{MOST_BITS, VOXELS};

/// What is left of one channel of a block, coded directly.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Escape {
    /// Bits of a number, 1 to 16.
    pub bits: u32,
    /// What number 0 stands for, in units of sums: 24 bits, signed.
    pub low: i32,
    /// Units of sums of a number's step.
    pub step: Scale,
    /// One number for each voxel.
    pub numbers: [u16; VOXELS],
}

/// Words of a part: one, and two for each bit of a voxel.
#[must_use]
#[inline]
pub const fn part_words(bits: u32) -> u32 {
    1 + 2 * bits
}

/// Most exponent of a step whose numbers have so many bits: what they reach stays below 2^25.
#[must_use]
#[inline]
pub const fn most_exponent(bits: u32) -> u32 {
    24 - bits
}

impl Escape {
    /// The least and the greatest low end.
    pub const LOWS: [i32; 2] = [-(1 << 23), (1 << 23) - 1];

    /// Greatest exponent of the step of numbers of so many bits.
    #[must_use]
    pub const fn most_exponent(bits: u32) -> u32 {
        most_exponent(bits)
    }

    /// What it adds at a place, in units of sums.
    ///
    /// # Panics
    /// When there is no such place.
    #[must_use]
    #[inline]
    pub const fn value(&self, place: usize) -> i32 {
        self.low + self.step.units() as i32 * self.numbers[place] as i32
    }

    /// Appends the part's words.
    pub fn write(&self, words: &mut Vec<u32>) {
        words.push((self.low << 8) as u32 | self.step.byte());
        let (mut waiting, mut filled) = (0_u64, 0);
        for number in self.numbers {
            waiting |= u64::from(number) << filled;
            filled += self.bits;
            if filled >= 32 {
                words.push(waiting as u32);
                waiting >>= 32;
                filled -= 32;
            }
        }
    }
}

/// Low end and step of the part that begins at word `first`.
#[inline]
fn form(words: &[u32], first: u32) -> (i32, i32) {
    let form = words[first as usize];
    (form as i32 >> 8, Scale::of_byte(form).units() as i32)
}

/// What a part adds at a place of its block, in units of sums.
///
/// # Panics
/// When there is no such place.
#[must_use]
#[inline]
pub fn part_value(words: &[u32], first: u32, bits: u32, place: usize) -> i32 {
    let (low, step) = form(words, first);
    low + step * crate::number(words, first + 1, place as u64 * u64::from(bits), bits) as i32
}

/// Bounds of what a part adds, in units of sums.
///
/// # Panics
/// When there is no such part.
#[must_use]
pub fn part_range(words: &[u32], first: u32, bits: u32) -> (i32, i32) {
    let (low, step) = form(words, first);
    (low, low + step * ((1 << bits) - 1))
}

/// Whether the step of a part keeps sums within 32 bits.
pub(crate) fn fits(words: &[u32], first: u32, bits: u32) -> bool {
    (1..=MOST_BITS).contains(&bits) && Scale::of_byte(words[first as usize]).exponent() <= most_exponent(bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_escape_comes_back() {
        for bits in 1..=16 {
            for (low, exponent) in [(Escape::LOWS[0], 0), (-7, most_exponent(bits)), (Escape::LOWS[1], 3)] {
                let numbers =
                    std::array::from_fn(|i| ((i as u32).wrapping_mul(0x9e37_79b9) >> (32 - bits)) as u16);
                let step = Scale::of_byte(exponent | 5 << 5);
                let escape = Escape { bits, low, step, numbers };
                let mut words = vec![0xdead_beef];
                escape.write(&mut words);
                assert_eq!(words.len() as u32, 1 + part_words(bits));
                assert!(fits(&words, 1, bits));
                let range = part_range(&words, 1, bits);
                for (place, number) in numbers.into_iter().enumerate() {
                    let value = part_value(&words, 1, bits, place);
                    assert_eq!(value, low + step.units() as i32 * i32::from(number));
                    assert!((range.0..=range.1).contains(&value));
                }
            }
        }
        assert!(!fits(&[most_exponent(4) + 1], 0, 4) && !fits(&[0], 0, 0) && !fits(&[0], 0, 17));
    }
}
