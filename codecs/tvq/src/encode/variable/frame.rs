//! Writes means and codes of a frame of the payload `variable` as words, brick by brick.

use crate::encode::closed_loop::Plane;
use crate::stream::bits::{Bits, mean_width};
use crate::stream::geometry::{BRICK, Geometry, number, positions};
use crate::stream::table::Table;

/// Bits of the largest of some counts.
#[must_use]
pub fn count_bits(counts: impl Iterator<Item = u8>) -> u32 {
    8 - counts.max().unwrap_or(0).leading_zeros()
}

/// Words of a brick whose blocks keep `codes` codes of `width` bits in all: planes, means and codes.
#[must_use]
pub const fn brick_words(planes: u32, mean_bits: u32, codes: u32, width: u32) -> u32 {
    2 * planes + (mean_bits + codes * width).div_ceil(32)
}

/// One frame of the payload `variable`: heads and indices. `None` if they exceed 2^32 words. `kept[s][c]` holds the
/// number of codes that each block of `planes[s][c]` keeps.
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

const _: () = assert!(BRICK * BRICK * BRICK == 64, "a plane of counts is two words");
