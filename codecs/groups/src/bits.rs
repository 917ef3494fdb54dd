//! Numbers of any width in words.

/// Numbers of any width one after the other, lowest bits first.
#[derive(Debug, Default)]
pub struct Bits {
    words: Vec<u32>,
    waiting: u64,
    filled: u32,
}

impl Bits {
    /// Appends a number that fits `width` bits, at most 32.
    pub fn push(&mut self, number: u32, width: u32) {
        debug_assert!(u64::from(number) < 1 << width, "{number} in {width} bits");
        self.waiting |= u64::from(number) << self.filled;
        self.filled += width;
        if self.filled >= 32 {
            self.words.push(self.waiting as u32);
            self.waiting >>= 32;
            self.filled -= 32;
        }
    }

    /// All words, the last filled up with zeros.
    #[must_use]
    pub fn finish(mut self) -> Vec<u32> {
        if self.filled > 0 {
            self.words.push(self.waiting as u32);
        }
        self.words
    }
}

/// The number of `width` bits, at most 16, that begins at bit `bit` from word `first` on.
///
/// # Panics
/// When it lies outside.
#[must_use]
#[inline]
pub fn number(words: &[u32], first: u32, bit: u64, width: u32) -> u32 {
    if width == 0 {
        return 0;
    }
    let (word, shift) = (first as usize + (bit >> 5) as usize, (bit & 31) as u32);
    let mut number = words[word] >> shift;
    if shift + width > 32 {
        number |= words[word + 1] << (32 - shift);
    }
    number & ((1 << width) - 1)
}

/// The code that some means count from, and the bits that each then takes.
#[must_use]
pub fn mean_width(means: impl Iterator<Item = u32>) -> (u32, u32) {
    let (low, high) = means.fold((u32::MAX, 0), |(low, high), m| (low.min(m), high.max(m)));
    let low = low.min(high);
    (low, width_of(high - low))
}

/// Bits of a number.
#[must_use]
#[inline]
pub(crate) const fn width_of(number: u32) -> u32 {
    32 - number.leading_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_wherever_they_begin() {
        let mut bits = Bits::default();
        let numbers: Vec<(u32, u32)> =
            (0..200_u32).map(|i| (i.wrapping_mul(0x9e37_79b9) >> (32 - (i % 16 + 1)), i % 16 + 1)).collect();
        numbers.iter().for_each(|(n, width)| bits.push(*n, *width));
        let words = bits.finish();
        let mut bit = 0;
        for (n, width) in numbers {
            assert_eq!(number(&words, 0, bit, width), n, "bit {bit}, {width} bits");
            bit += u64::from(width);
        }
        assert_eq!(number(&words, 0, 1 << 40, 0), 0, "no bits are read nowhere");
    }

    #[test]
    fn means_count_from_the_least() {
        assert_eq!(mean_width([7, 5, 9].into_iter()), (5, 3));
        assert_eq!(mean_width([6, 6].into_iter()), (6, 0));
        assert_eq!(mean_width(std::iter::empty()), (0, 0));
    }
}
