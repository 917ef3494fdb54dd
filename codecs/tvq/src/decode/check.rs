//! Checks of a frame before a decoder uses its numbers.

use cvr_groups::Limits;

use super::Frame;
use crate::stream::geometry::{Payload, VALUE_BITS, number, positions};
use crate::stream::table::{Table, fixed_words};

/// Checks that every mean, code and count of a frame stays within its table.
///
/// # Errors
/// A sentence about the first that does not.
pub fn check_frame(frame: &Frame<'_>, tables: &[Table]) -> Result<(), String> {
    match frame.geometry.payload {
        Payload::Fixed => check_fixed(frame, tables),
        Payload::Variable => check_variable(frame, tables),
    }
}

/// A mean is at most one step above the top.
const fn greatest_mean(table: &Table) -> u32 {
    (2 << VALUE_BITS) >> table.mean_shift
}

fn check_mean(table: &Table, code: u32) -> Result<(), String> {
    if code <= greatest_mean(table) { Ok(()) } else { Err(format!("a mean of code {code}")) }
}

fn check_fixed(frame: &Frame<'_>, tables: &[Table]) -> Result<(), String> {
    let g = frame.geometry;
    let count = |sub| g.sub_volume(sub).1.map(u64::from).iter().product::<u64>();
    let words = |(table, sub): (&Table, [u32; 3])| fixed_words(table, count(sub));
    let of_channel: u64 = tables.iter().zip(positions(g.sub_grid.to_array())).map(words).sum();
    let mut begun = 0;
    for (table, sub) in tables.iter().zip(positions(g.sub_grid.to_array())) {
        let count = count(sub);
        check_mean(table, table.mean_base + ((1 << table.width) - 1))?;
        // Sub-volumes follow each other without gaps, so that none reaches into another.
        if (u64::from(table.start), u64::from(table.channel_words)) != (begun, of_channel) {
            return Err(format!(
                "the indices of sub-volume {sub:?} begin at word {} of {} and not at {begun} of {of_channel}",
                table.start, table.channel_words
            ));
        }
        begun += fixed_words(table, count);
        for channel in 0..u64::from(g.channels) {
            let start = u64::from(table.start) + channel * u64::from(table.channel_words);
            let end = start * 32 + count * table.block_bits();
            let start = match u32::try_from(start) {
                Ok(start) if end <= frame.index.len() as u64 * 32 => start,
                _ => return Err(format!("the indices of sub-volume {sub:?} end at bit {end}")),
            };
            let mut bit = count * u64::from(table.width);
            for book in &table.books {
                let named = |n: u64| frame.number(start, bit + n * u64::from(book.width), book.width);
                let whole = book.size == 1 << book.width;
                if let Some(n) = (0..count).find(|n| !whole && named(*n) >= book.size) {
                    return Err(format!("block {n} of sub-volume {sub:?} names a codeword of {}", book.size));
                }
                bit += count * u64::from(book.width);
            }
        }
    }
    Ok(())
}

fn check_variable(frame: &Frame<'_>, tables: &[Table]) -> Result<(), String> {
    let (g, groups) = (frame.geometry, frame.groups());
    let codewords = |t: &Table| t.books.iter().map(|book| book.size).collect();
    let codewords: Vec<Vec<u32>> = tables.iter().map(codewords).collect();
    for channel in 0..g.channels as usize {
        for (n, group) in positions(g.groups.to_array()).enumerate() {
            let (first, size) = g.group(group);
            let s = number([0, 1, 2].map(|a| first[a] / g.sub_blocks[a]), g.sub_grid.to_array());
            let limits = Limits {
                blocks: size.iter().product(),
                code_bits: tables[s].width,
                codewords: &codewords[s],
                greatest_mean: greatest_mean(&tables[s]),
            };
            cvr_groups::check(&groups, channel * g.groups.voxels() as usize + n, &limits)
                .map_err(|problem| format!("group {group:?} of channel {channel}: {problem}"))?;
        }
    }
    Ok(())
}
