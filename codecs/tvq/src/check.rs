//! What a decoder checks of a frame before it trusts a single number of it.

use crate::decode::Frame;
use crate::geometry::{Payload, VALUE_BITS, number, positions};
use crate::table::Table;

/// Whether every mean, code and count of a frame stays within its table.
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
    for (table, sub) in tables.iter().zip(positions(g.sub_grid.to_array())) {
        let count: u64 = g.sub_volume(sub).1.map(u64::from).iter().product();
        check_mean(table, table.mean_base + ((1 << table.width) - 1))?;
        for channel in 0..u64::from(g.channels) {
            let first = (u64::from(table.start) + channel * u64::from(table.channel_words)) << 5;
            let end = first + count * table.block_bits();
            if end > frame.index.len() as u64 * 32 {
                return Err(format!("the indices of sub-volume {sub:?} end at bit {end}"));
            }
            let mut bit = first + count * u64::from(table.width);
            for book in &table.books {
                let named = |n: u64| frame.number(bit + n * u64::from(book.width), book.width);
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
    let mut heads = frame.heads.chunks_exact(g.head_words() as usize);
    for _ in 0..g.channels {
        for brick in positions(g.bricks.to_array()) {
            let Some(head) = heads.next() else { return Err("heads of bricks are missing".to_owned()) };
            let (first, size) = g.brick(brick);
            let sub = [0, 1, 2].map(|a| first[a] / g.sub_blocks[a]);
            let table = &tables[number(sub, g.sub_grid.to_array())];
            let (count, mean_width) = (size.iter().product::<u32>(), head[1] >> 16);
            if mean_width > 16 {
                return Err(format!("means of {mean_width} bits in brick {brick:?}"));
            }
            check_mean(table, (head[1] & 0xffff) + ((1 << mean_width) - 1))?;
            let mut bit = u64::from(head[0]) + u64::from(count * mean_width);
            for n in 0..count {
                let plane = |j: u32| head[(2 + 2 * j + n / 32) as usize] >> (n % 32) & 1;
                let kept: u32 = (0..g.planes).map(|j| plane(j) << j).sum();
                let end = bit + u64::from(kept * table.width);
                if kept as usize > table.books.len() || end > frame.index.len() as u64 * 32 {
                    return Err(format!("block {n} of brick {brick:?} keeps {kept} codes up to bit {end}"));
                }
                for book in &table.books[..kept as usize] {
                    if frame.number(bit, table.width) >= book.size {
                        return Err(format!(
                            "block {n} of brick {brick:?} names a codeword of {}",
                            book.size
                        ));
                    }
                    bit += u64::from(table.width);
                }
            }
            if bit > frame.index.len() as u64 * 32 {
                return Err(format!("the means of brick {brick:?} end at bit {bit}"));
            }
        }
    }
    Ok(())
}
