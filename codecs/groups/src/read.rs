//! What a group says of one block: the twin of `groups.wgsl`.

use crate::bits::number;
use crate::escape::part_words;
use crate::head::{Head, Records, plane_words};

/// The groups of one frame.
#[derive(Copy, Clone, Debug)]
pub struct Groups<'a> {
    /// Two words for each group.
    pub heads: &'a [u32],
    /// Words of all groups.
    pub words: &'a [u32],
    /// Parts of an escape.
    pub parts: u32,
}

/// What a group says of one block.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Code of its mean.
    pub mean: u32,
    /// How many codes it keeps.
    pub count: u32,
    /// Where they begin: so many bits from a word on.
    pub start: u32,
    /// See `start`.
    pub bit: u32,
    /// First word of its escape.
    pub rest: u32,
    /// Bits of a voxel of its escape; 0 where it has none.
    pub rest_bits: u32,
}

/// Number of set bits below place `n` of two words. A plane of one word has 0 as its second.
#[inline]
const fn below(low: u32, high: u32, n: u32) -> u32 {
    if n < 32 {
        return (low & ((1 << n) - 1)).count_ones();
    }
    low.count_ones() + (high & ((1 << (n - 32)) - 1)).count_ones()
}

/// Bit `n` of 64.
#[inline]
const fn bit(low: u32, high: u32, n: u32) -> u32 {
    if n < 32 {
        return (low >> n) & 1;
    }
    (high >> (n - 32)) & 1
}

impl Groups<'_> {
    #[inline]
    fn word(&self, i: u32) -> u32 {
        self.words[i as usize]
    }

    /// A plane's words.
    #[inline]
    fn plane(&self, first: u32, words: u32) -> (u32, u32) {
        (self.word(first), if words == 2 { self.word(first + 1) } else { 0 })
    }

    /// The head of a group.
    ///
    /// # Panics
    /// When there is no such group.
    #[must_use]
    #[inline]
    pub fn head(&self, group: usize) -> Head {
        Head::of(self.heads[2 * group], self.heads[2 * group + 1])
    }

    /// Block `n` of a group of `blocks` blocks whose codes have `code_bits` bits.
    ///
    /// # Panics
    /// When there is no such block, or the words were not checked.
    #[must_use]
    pub fn block(&self, group: usize, n: u32, blocks: u32, code_bits: u32) -> Block {
        let head = self.head(group);
        let bare = Block { mean: head.base, count: 0, start: 0, bit: 0, rest: 0, rest_bits: 0 };
        let (mut start, mut place, mut records) = (head.start, n, blocks);
        match head.records {
            Records::None => return bare,
            Records::All => {}
            Records::Named => {
                let (low, high) = self.plane(start, 2);
                if bit(low, high, n) == 0 {
                    return bare;
                }
                place = below(low, high, n);
                records = low.count_ones() + high.count_ones();
                start += 2;
            }
        }
        let size = plane_words(records);
        let (mut before, mut count) = (0, 0);
        for j in 0..head.planes {
            let (low, high) = self.plane(start, size);
            before += below(low, high, place) << j;
            count += bit(low, high, place) << j;
            start += size;
        }
        let (mut rest, mut rest_bits) = (0, 0);
        if let Some([least, planes]) = head.escapes {
            let (low, high) = self.plane(start, size);
            start += size;
            let size = plane_words(low.count_ones() + high.count_ones());
            if bit(low, high, place) == 1 {
                let nth = below(low, high, place);
                let (mut bits, mut all) = (least, (nth + 1) * least);
                for j in 0..planes {
                    let (low, high) = self.plane(start + j * size, size);
                    let own = bit(low, high, nth);
                    bits += own << j;
                    all += (below(low, high, nth) + own) << j;
                }
                // As many parts lie between the group's first word and the end of this escape.
                rest = head.start - self.parts * ((nth + 1) * part_words(0) + 2 * all);
                rest_bits = bits;
            }
            start += planes * size;
        }
        let mean = head.base + number(self.words, start, u64::from(place * head.mean_bits), head.mean_bits);
        Block { mean, count, start, bit: records * head.mean_bits + before * code_bits, rest, rest_bits }
    }

    /// Code `i` of a block whose codes have `code_bits` bits.
    ///
    /// # Panics
    /// When there is none.
    #[must_use]
    #[inline]
    pub fn code(&self, block: &Block, i: u32, code_bits: u32) -> u32 {
        number(self.words, block.start, u64::from(block.bit + i * code_bits), code_bits)
    }
}
