//! The indices of the payload `fixed`, block by block.
//!
//! A stream stores the means of all blocks, then the codes of each codebook, so that its beginning is the coarse
//! volume. A fetch is faster if the numbers of a block are adjacent, usually in one word. A decoder reorders them once
//! when it opens a stream. Both orders have the same size.

use cvr_groups::Bits;

use super::Frame;
use crate::stream::geometry::positions;
use crate::stream::table::Table;

/// The records of a checked frame: channel by channel, and sub-volume by sub-volume in whole words. A record is a
/// block's mean, then its codes in the order of the codebooks. A word 0 follows the last record.
#[must_use]
pub fn records(frame: &Frame<'_>, tables: &[Table]) -> Vec<u32> {
    let g = frame.geometry;
    let mut words = Vec::with_capacity(frame.index.len());
    for channel in 0..g.channels {
        for (table, sub) in tables.iter().zip(positions(g.sub_grid.to_array())) {
            let count: u64 = g.sub_volume(sub).1.map(u64::from).iter().product();
            let start = table.start + channel * table.channel_words;
            let mut bits = Bits::default();
            for n in 0..count {
                let mut plane = 0;
                for width in std::iter::once(table.width).chain(table.books.iter().map(|b| b.width)) {
                    bits.push(frame.number(start, plane + n * u64::from(width), width), width);
                    plane += count * u64::from(width);
                }
            }
            words.extend(bits.finish());
        }
    }
    words.push(0);
    words
}
