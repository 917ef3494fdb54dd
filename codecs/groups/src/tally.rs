//! How many words a group takes.

use crate::escape::part_words;
use crate::head::{plane_words, planes_of};

/// What the blocks of a group come to.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Blocks.
    pub blocks: u32,
    /// Those that need no record: their mean is the base, and they keep nothing else.
    pub bare: u32,
    /// Codes of all.
    pub codes: u32,
    /// Most codes of one.
    pub most_codes: u32,
    /// Blocks that are escaped.
    pub escapes: u32,
    /// Bits of a voxel of all escaped blocks, added up.
    pub escape_bits: u32,
    /// The least and the most of these.
    pub escape_range: [u32; 2],
}

impl Tally {
    /// One more block. Its mean is the base or not, it keeps so many codes, and it is escaped in so many bits of a voxel.
    #[inline]
    pub fn add(&mut self, at_base: bool, codes: u32, escape: Option<u32>) {
        self.blocks += 1;
        self.bare += u32::from(at_base && codes == 0 && escape.is_none());
        self.codes += codes;
        self.most_codes = self.most_codes.max(codes);
        if let Some(bits) = escape {
            let [least, most] = if self.escapes == 0 { [bits; 2] } else { self.escape_range };
            self.escape_range = [least.min(bits), most.max(bits)];
            self.escapes += 1;
            self.escape_bits += bits;
        }
    }

    /// Words, where `records` blocks have records.
    const fn words_of(&self, records: u32, mean_bits: u32, code_bits: u32, parts: u32) -> u32 {
        let mask = if records < self.blocks { 2 } else { 0 };
        let planes = (planes_of(self.most_codes) + (self.escapes > 0) as u32) * plane_words(records);
        let [least, most] = self.escape_range;
        let widths = planes_of(most - least) * plane_words(self.escapes);
        let escapes =
            parts * (self.escapes * part_words(0) + self.escape_bits * (part_words(1) - part_words(0)));
        mask + planes + widths + escapes + (records * mean_bits + self.codes * code_bits).div_ceil(32)
    }

    /// Blocks that have records where the group takes the fewest words: all, where the mask takes more than it saves.
    #[must_use]
    pub const fn records(&self, mean_bits: u32, code_bits: u32, parts: u32) -> u32 {
        let named = self.blocks - self.bare;
        if named == 0
            || self.words_of(named, mean_bits, code_bits, parts)
                < self.words_of(self.blocks, mean_bits, code_bits, parts)
        {
            named
        } else {
            self.blocks
        }
    }

    /// Words of the group, its head aside: escapes of `parts` parts, means of `mean_bits` and codes of `code_bits` bits.
    #[must_use]
    #[inline]
    pub const fn words(&self, mean_bits: u32, code_bits: u32, parts: u32) -> u32 {
        match self.records(mean_bits, code_bits, parts) {
            0 => 0,
            records => self.words_of(records, mean_bits, code_bits, parts),
        }
    }
}
