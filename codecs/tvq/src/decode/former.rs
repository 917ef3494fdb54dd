//! Groups as versions 1 and 2 of the stream have them: every block has a record, planes have two words, and nothing is coded
//! directly. They become groups of today once, when a stream is opened; none grows.

use cvr_groups::{Codes, Writer};

use super::Frame;
use crate::stream::geometry::{HEAD_WORDS, number, positions};
use crate::stream::table::Table;

/// Most planes of counts.
const MOST_PLANES: u32 = 6;

/// Heads and words of a frame of version 3 that is this frame of version 1 or 2. What is read lies inside; whether codes and
/// means are within their bounds is for the check of version 3 to say.
///
/// # Errors
/// A sentence about the first number that leads outside.
pub fn rewritten(frame: &Frame<'_>, tables: &[Table]) -> Result<(Vec<u32>, Vec<u32>), String> {
    let g = frame.geometry;
    let mut writer = Writer::new(1);
    let mut heads = frame.heads.chunks_exact(HEAD_WORDS as usize);
    for _ in 0..g.channels {
        for group in positions(g.groups.to_array()) {
            let Some(&[start, form]) = heads.next() else { return Err("a head is missing".to_owned()) };
            let (first, size) = g.group(group);
            let sub = [0, 1, 2].map(|a| first[a] / g.sub_blocks[a]);
            let width = tables[number(sub, g.sub_grid.to_array())].width;
            let (count, mean_bits, planes) = (size.iter().product::<u32>(), form >> 16 & 31, form >> 24);
            if mean_bits > 16 || planes > MOST_PLANES {
                return Err(format!("means of {mean_bits} bits and {planes} planes in group {group:?}"));
            }
            let behind = u64::from(start) + 2 * u64::from(planes);
            if behind > frame.index.len() as u64 {
                return Err(format!("the planes of group {group:?} end at word {behind}"));
            }
            let word = |j: u32, n: u32| frame.index[(start + 2 * j + n / 32) as usize];
            let kept = |n: u32| (0..planes).map(|j| (word(j, n) >> (n % 32) & 1) << j).sum::<u32>();
            let counts: Vec<u32> = (0..count).map(kept).collect();
            let end = u64::from(count * mean_bits) + u64::from(counts.iter().sum::<u32>() * width);
            if end > (frame.index.len() as u64 - behind) * 32 {
                return Err(format!("the codes of group {group:?} end at bit {end}"));
            }
            let read = |bit: u32, width: u32| frame.number(behind as u32, u64::from(bit), width);
            let all: u32 = counts.iter().sum();
            let code = |i: u32| read(count * mean_bits + i * width, width) as u16;
            let codes: Vec<u16> = (0..all).map(code).collect();
            let base = form & 0xffff;
            let mut rest = &codes[..];
            let blocks = counts.iter().enumerate().map(|(n, kept)| {
                let (own, others) = rest.split_at(*kept as usize);
                rest = others;
                Codes { mean: base + read(n as u32 * mean_bits, mean_bits), codes: own, escape: &[] }
            });
            let blocks: Vec<Codes<'_>> = blocks.collect();
            writer.push(&blocks, (base, mean_bits), width).ok_or("a frame of more than 2^32 words")?;
        }
    }
    Ok(writer.finish())
}
