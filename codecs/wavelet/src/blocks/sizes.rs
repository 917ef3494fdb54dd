//! Sizes of a stream before it is written.

use super::write::{Coded, Size};

/// Low-pass coefficients of the blocks that have bits, and the size of a stream.
#[derive(Clone, Debug)]
pub struct Sizes {
    /// Lowest and highest. The lowest is above the highest if no block has bits.
    low: i32,
    high: i32,
    /// Number of blocks by the bits of their root beyond whole bytes.
    beyond: [u64; 8],
    bytes: u64,
}

impl Sizes {
    /// No blocks.
    pub const NONE: Self = Self { low: i32::MAX, high: i32::MIN, beyond: [0; 8], bytes: 0 };

    /// Adds a block.
    pub fn add(&mut self, coded: &Coded) {
        let Some(Size { root, children }) = coded.size() else { return };
        (self.low, self.high) = (self.low.min(coded.low()), self.high.max(coded.low()));
        self.beyond[(root % 8) as usize] += 1;
        self.bytes += u64::from(root / 8 + children);
    }

    /// Both together.
    pub fn and(mut self, other: &Self) -> Self {
        (self.low, self.high) = (self.low.min(other.low), self.high.max(other.high));
        self.beyond.iter_mut().zip(other.beyond).for_each(|(beyond, other)| *beyond += other);
        self.bytes += other.bytes;
        self
    }

    /// What low-pass coefficients count from, and their bits.
    pub const fn low(&self) -> (i32, u32) {
        if self.low > self.high {
            return (0, 0);
        }
        (self.low, 32 - self.high.wrapping_sub(self.low).leading_zeros())
    }

    /// Bytes of the bits of all blocks.
    pub fn bytes(&self) -> u64 {
        let (_, width) = self.low();
        let of = |(beyond, count): (usize, &u64)| count * u64::from((beyond as u32 + width).div_ceil(8));
        self.bytes + self.beyond.iter().enumerate().map(of).sum::<u64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::shape::Coefficients;

    /// Some coefficients that need classes and children, and some that need none.
    fn coefficients(seed: u32, edge: usize) -> Coefficients {
        let at = |i: usize| (i as u32 * 8 + seed).wrapping_mul(0x9e37_79b9);
        let place = |i: usize| -> [i32; 7] {
            std::array::from_fn(|slot| match at(i) >> 29 {
                0..4 => 0,
                shift => (at(i + 99 * slot) >> 3) as i32 >> (30 - shift),
            })
        };
        let high = (0..Coefficients::places(edge)).map(place).collect();
        Coefficients { low: seed as i32 * 100 - 300, high }
    }

    #[test]
    fn blocks_have_the_size_that_was_foretold() {
        for edge in [8, 16] {
            let blocks: Vec<_> = (0..9).map(|seed| coefficients(seed, edge)).collect();
            let mut sizes = Sizes::NONE;
            blocks.iter().for_each(|block| sizes.add(&Coded::of(block)));
            assert_eq!(sizes.low(), (-300, 10));
            let written =
                blocks.iter().map(|block| Coded::of(block).bytes(block, sizes.low()).unwrap().len());
            assert_eq!(written.sum::<usize>() as u64, sizes.bytes(), "{edge}");
        }
        let constant = Coefficients { low: 5, high: vec![[0; 7]; 73] };
        let mut sizes = Sizes::NONE;
        sizes.add(&Coded::of(&constant));
        assert_eq!((sizes.low(), sizes.bytes()), ((0, 0), 0));
    }
}
