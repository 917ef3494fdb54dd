//! Indices and codes into words, lowest bits first.

/// Packs numbers of equal width without gaps. A number may span two words.
#[derive(Debug)]
pub struct BitPacker {
    bits: u32,
    waiting: u64,
    filled: u32,
}

impl BitPacker {
    /// A packer for numbers of `bits` bits, 1 to 32.
    #[must_use]
    pub const fn new(bits: u32) -> Self {
        Self { bits, waiting: 0, filled: 0 }
    }

    /// Appends one number, which fits the width.
    pub fn push(&mut self, number: u32, words: &mut Vec<u32>) {
        debug_assert!(u64::from(number) < 1 << self.bits);
        self.waiting |= u64::from(number) << self.filled;
        self.filled += self.bits;
        if self.filled >= 32 {
            words.push(self.waiting as u32);
            self.waiting >>= 32;
            self.filled -= 32;
        }
    }

    /// Ends a frame or table: the unfinished word is written.
    pub fn flush(&mut self, words: &mut Vec<u32>) {
        if self.filled > 0 {
            words.push(self.waiting as u32);
            (self.waiting, self.filled) = (0, 0);
        }
    }
}

/// Number `i` of packed numbers with `bits` bits. The inverse of [`BitPacker`]. Each shader contains its own version.
///
/// # Panics
/// When there is no such number.
#[must_use]
#[inline]
pub fn unpack(words: &[u32], bits: u32, i: usize) -> u32 {
    // 32 numbers fill `bits` words, so that places in bits never overflow.
    let bit = (i & 31) * bits as usize;
    let (word, shift) = ((i >> 5) * bits as usize + (bit >> 5), bit as u32 & 31);
    let mut number = words[word] >> shift;
    if shift + bits > 32 {
        number |= words[word + 1] << (32 - shift);
    }
    number & (((1_u64 << bits) - 1) as u32)
}

/// The first of `count` packed numbers that is `size` or more, with its position: an index without a codeword.
///
/// # Panics
/// When there are fewer numbers.
#[must_use]
pub fn first_beyond(words: &[u32], bits: u32, count: usize, size: u32) -> Option<(usize, u32)> {
    if u64::from(size) == 1 << bits {
        return None;
    }
    (0..count).map(|i| (i, unpack(words, bits, i))).find(|(_, index)| *index >= size)
}

/// Least and largest code of each of `size` codewords. A codeword has `dimension` codes of `bits` bits.
///
/// # Panics
/// When there are fewer codes.
#[must_use]
pub fn code_ranges(words: &[u32], bits: u32, dimension: usize, size: usize) -> Vec<(u32, u32)> {
    let of_codeword = |k: usize| {
        let codes = (k * dimension..(k + 1) * dimension).map(|i| unpack(words, bits, i));
        codes.fold((u32::MAX, 0), |(low, high), code| (low.min(code), high.max(code)))
    };
    (0..size).map(of_codeword).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_cross_words() {
        let mut packer = BitPacker::new(12);
        let mut words = Vec::new();
        [0x123, 0x456, 0x789, 0xabc].into_iter().for_each(|n| packer.push(n, &mut words));
        packer.flush(&mut words);
        packer.flush(&mut words);
        assert_eq!(words, [0x8945_6123, 0xabc7]);
        assert_eq!([0, 1, 2, 3].map(|i| unpack(&words, 12, i)), [0x123, 0x456, 0x789, 0xabc]);
    }

    #[test]
    fn what_is_beyond_and_what_codewords_reach_is_found() {
        let (mut packer, mut words) = (BitPacker::new(8), Vec::new());
        [3, 9, 2, 7, 200, 1].into_iter().for_each(|n| packer.push(n, &mut words));
        packer.flush(&mut words);
        assert_eq!(first_beyond(&words, 8, 6, 10), Some((4, 200)));
        assert_eq!((first_beyond(&words, 8, 4, 10), first_beyond(&words, 8, 6, 256)), (None, None));
        assert_eq!(code_ranges(&words, 8, 3, 2), [(2, 9), (1, 200)]);
    }

    #[test]
    fn numbers_of_every_width_come_back() {
        for bits in 1..=32 {
            let numbers: Vec<u32> = (0..77_u32).map(|i| i.wrapping_mul(0x9e37_79b9) >> (32 - bits)).collect();
            let (mut packer, mut words) = (BitPacker::new(bits), Vec::new());
            numbers.iter().for_each(|n| packer.push(*n, &mut words));
            packer.flush(&mut words);
            let back: Vec<u32> = (0..numbers.len()).map(|i| unpack(&words, bits, i)).collect();
            assert_eq!(back, numbers, "{bits} bits");
        }
    }
}
