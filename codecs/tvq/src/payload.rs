//! Means and codes of a frame into words.

use cvr_codebook::pack::BitPacker;

use crate::code::Plane;
use crate::geometry::{BRICK, Geometry, number, positions};
use crate::table::Table;

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
        self.waiting |= u64::from(number) << self.filled;
        self.filled += width;
        if self.filled >= 32 {
            self.words.push(self.waiting as u32);
            self.waiting >>= 32;
            self.filled -= 32;
        }
    }

    /// Fills the last word up with zeros.
    pub fn end_word(&mut self) {
        if self.filled > 0 {
            self.words.push(self.waiting as u32);
            (self.waiting, self.filled) = (0, 0);
        }
    }

    /// All words, the last filled up with zeros.
    #[must_use]
    pub fn finish(mut self) -> Vec<u32> {
        self.end_word();
        self.words
    }
}

/// Bits that the largest of some counts takes.
#[must_use]
pub fn count_bits(counts: impl Iterator<Item = u8>) -> u32 {
    8 - counts.max().unwrap_or(0).leading_zeros()
}

/// Words of a brick whose blocks keep so many codes of `width` bits in all: planes, means and codes.
#[must_use]
pub const fn brick_words(planes: u32, mean_bits: u32, codes: u32, width: u32) -> u32 {
    2 * planes + (mean_bits + codes * width).div_ceil(32)
}

/// Words that the blocks of a sub-volume take in one channel.
#[must_use]
pub fn fixed_words(table: &Table, blocks: u64) -> u64 {
    (table.block_bits() * blocks).div_ceil(32)
}

/// One frame of the payload `fixed`: channel by channel, sub-volume by sub-volume, the means and then the codes of each
/// codebook. `planes[s][c]` is sub-volume `s`, channel `c`.
#[must_use]
pub fn fixed_frame(tables: &[Table], planes: &[&[Plane]]) -> Vec<u32> {
    let mut words = Vec::new();
    for channel in 0..planes.first().map_or(0, |p| p.len()) {
        for (table, planes) in tables.iter().zip(planes) {
            let plane = &planes[channel];
            let mut bits = Bits::default();
            plane.means.iter().for_each(|m| bits.push(m - table.mean_base, table.width));
            for (b, book) in table.books.iter().enumerate() {
                let codes = plane.codes.iter().skip(b).step_by(plane.books.max(1));
                codes.for_each(|code| bits.push((*code).into(), book.width));
            }
            words.extend(bits.finish());
        }
    }
    // So that there is a word even where nothing needs a bit.
    words.push(0);
    words
}

/// The code that some means count from, and the bits that each then takes.
#[must_use]
pub fn mean_width(means: &[u32]) -> (u32, u32) {
    let (low, high) = means.iter().fold((u32::MAX, 0), |(low, high), m| (low.min(*m), high.max(*m)));
    let low = low.min(high);
    (low, 32 - (high - low).leading_zeros())
}

/// One frame of the payload `variable`: heads and indices, or `None` where they exceed 2^32 words. `kept[s][c]` says how
/// many codes each block of `planes[s][c]` keeps.
#[must_use]
pub fn variable_frame(
    g: &Geometry,
    tables: &[Table],
    planes: &[&[Plane]],
    kept: &[&[Vec<u8>]],
) -> Option<(Vec<u32>, Vec<u32>)> {
    let mut heads = Vec::with_capacity(g.frame_heads() as usize);
    let mut bits = Bits::default();
    for channel in 0..g.channels as usize {
        for brick in positions(g.bricks.to_array()) {
            let (first, size) = g.brick(brick);
            let sub = [0, 1, 2].map(|a| first[a] / g.sub_blocks[a]);
            let (sub_first, sub_size) = g.sub_volume(sub);
            let s = number(sub, g.sub_grid.to_array());
            let (plane, kept, table) = (&planes[s][channel], &kept[s][channel], &tables[s]);
            let in_sub = |p: [u32; 3]| number([0, 1, 2].map(|a| first[a] + p[a] - sub_first[a]), sub_size);
            let blocks: Vec<usize> = positions(size).map(in_sub).collect();
            let (base, width) = mean_width(&blocks.iter().map(|n| plane.means[*n]).collect::<Vec<_>>());
            let planes = count_bits(blocks.iter().map(|n| kept[*n]));
            heads.push(u32::try_from(bits.words.len()).ok()?);
            heads.push(base | width << 16 | planes << 24);
            for j in 0..planes {
                let mut words = [0_u32; 2];
                for (place, n) in blocks.iter().enumerate() {
                    words[place / 32] |= (u32::from(kept[*n]) >> j & 1) << (place % 32);
                }
                bits.words.extend(words);
            }
            blocks.iter().for_each(|n| bits.push(plane.means[*n] - base, width));
            let books = plane.books;
            for n in blocks {
                let codes = &plane.codes[n * books..n * books + usize::from(kept[n])];
                codes.iter().for_each(|code| bits.push((*code).into(), table.width));
            }
            bits.end_word();
        }
    }
    bits.words.push(0);
    Some((heads, bits.words))
}

/// Entries of codebooks in words.
#[must_use]
pub fn packed_entries(codes: impl Iterator<Item = u16>, bits: u32) -> Vec<u32> {
    let (mut packer, mut words) = (BitPacker::new(bits), Vec::new());
    codes.for_each(|code| packer.push(code.into(), &mut words));
    packer.flush(&mut words);
    if words.is_empty() {
        words.push(0);
    }
    words
}

const _: () = assert!(BRICK * BRICK * BRICK == 64, "a plane of counts is two words");
