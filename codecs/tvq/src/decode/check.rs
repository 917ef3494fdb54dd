//! Checks of a frame before a decoder uses its numbers.

use super::Frame;
use crate::stream::geometry::{HEAD_WORDS, MOST_PLANES, Payload, VALUE_BITS, number, positions};
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

fn check_mean(table: &Table, code: u32) -> Result<(), String> {
    // A mean is at most one step above the top.
    let value = u64::from(code) << table.mean_shift;
    if value <= 2 << VALUE_BITS { Ok(()) } else { Err(format!("a mean of code {code}")) }
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
    let g = frame.geometry;
    let mut heads = frame.heads.chunks_exact(HEAD_WORDS as usize);
    for _ in 0..g.channels {
        for brick in positions(g.bricks.to_array()) {
            let Some(&[start, form]) = heads.next() else { return Err("a head is missing".to_owned()) };
            let (first, size) = g.brick(brick);
            let sub = [0, 1, 2].map(|a| first[a] / g.sub_blocks[a]);
            let table = &tables[number(sub, g.sub_grid.to_array())];
            let (count, mean_width, planes) = (size.iter().product::<u32>(), (form >> 16) & 31, form >> 24);
            if mean_width > 16 || planes > MOST_PLANES {
                return Err(format!("means of {mean_width} bits and {planes} planes in brick {brick:?}"));
            }
            check_mean(table, (form & 0xffff) + ((1 << mean_width) - 1))?;
            let behind = u64::from(start) + 2 * u64::from(planes);
            if behind > frame.index.len() as u64 {
                return Err(format!("the planes of brick {brick:?} end at word {behind}"));
            }
            let end = (frame.index.len() as u64 - behind) * 32;
            let mut bit = u64::from(count * mean_width);
            for n in 0..count {
                let word = |j: u32| frame.index[(start + 2 * j + n / 32) as usize];
                let kept: u32 = (0..planes).map(|j| (word(j) >> (n % 32) & 1) << j).sum();
                if kept as usize > table.books.len() || bit + u64::from(kept * table.width) > end {
                    return Err(format!("block {n} of brick {brick:?} keeps {kept} codes"));
                }
                for book in &table.books[..kept as usize] {
                    if frame.number(behind as u32, bit, table.width) >= book.size {
                        return Err(format!(
                            "block {n} of brick {brick:?} names a codeword of {}",
                            book.size
                        ));
                    }
                    bit += u64::from(table.width);
                }
            }
            if bit > end {
                return Err(format!("the means of brick {brick:?} end at bit {bit}"));
            }
        }
    }
    Ok(())
}
