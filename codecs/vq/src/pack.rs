//! Indices and codes into words, lowest bits first.

/// Packs numbers of equal width one after the other; a number may lie in two words.
#[derive(Debug)]
pub struct BitPacker {
    bits: u32,
    waiting: u64,
    filled: u32,
}

impl BitPacker {
    /// For numbers of `bits` bits, 1 to 32.
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

    /// Ends a frame or table: what waits becomes a word.
    pub fn flush(&mut self, words: &mut Vec<u32>) {
        if self.filled > 0 {
            words.push(self.waiting as u32);
            (self.waiting, self.filled) = (0, 0);
        }
    }
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
    }
}
