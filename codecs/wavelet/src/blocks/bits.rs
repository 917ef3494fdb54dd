//! Numbers of any width, one after the other, lowest bits first.

/// Bits while they are written.
#[derive(Debug, Default)]
pub struct Bits {
    bytes: Vec<u8>,
    waiting: u64,
    filled: u32,
}

impl Bits {
    /// Appends a number that fits `width` bits, at most 32.
    pub fn push(&mut self, number: u32, width: u32) {
        debug_assert!(u64::from(number) < 1 << width, "{number} in {width} bits");
        self.waiting |= u64::from(number) << self.filled;
        self.filled += width;
        while self.filled >= 8 {
            self.bytes.push(self.waiting as u8);
            self.waiting >>= 8;
            self.filled -= 8;
        }
    }

    /// Fills the last byte up with zeros.
    pub fn align(&mut self) {
        if self.filled > 0 {
            self.push(0, 8 - self.filled);
        }
    }

    /// Number of whole bytes.
    pub const fn len(&self) -> usize {
        self.bytes.len()
    }

    /// All bytes. The last is filled up with zeros.
    pub fn finish(mut self) -> Vec<u8> {
        self.align();
        self.bytes
    }
}

/// Bits of a number.
#[inline]
pub const fn width_of(number: u32) -> u32 {
    32 - number.leading_zeros()
}

#[cfg(test)]
mod tests {
    use cvr_core::kit::number;

    use super::*;

    #[test]
    fn numbers_come_back_wherever_they_begin() {
        let mut bits = Bits::default();
        let numbers: Vec<(u32, u32)> =
            (0..300_u32).map(|i| (i.wrapping_mul(0x9e37_79b9) >> (31 - i % 32), i % 32 + 1)).collect();
        numbers.iter().for_each(|(n, width)| bits.push(*n, *width));
        let mut bytes = bits.finish();
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        let words: Vec<u32> =
            bytes.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect();
        let mut bit = 0;
        for (n, width) in numbers {
            assert_eq!(number(&words, 0, bit, width), n, "bit {bit}, {width} bits");
            bit += width;
        }
    }

    #[test]
    fn a_byte_is_filled_up() {
        let mut bits = Bits::default();
        bits.push(5, 3);
        bits.align();
        bits.align();
        bits.push(0x1234, 16);
        assert_eq!((bits.len(), bits.finish()), (3, vec![5, 0x34, 0x12]));
    }
}
