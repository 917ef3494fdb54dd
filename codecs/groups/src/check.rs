//! What a decoder checks of a group before it trusts a single number of it.

use crate::escape::{fits, part_words};
use crate::head::{Records, plane_words};
use crate::read::Groups;
use crate::{BLOCKS, MOST_BITS, MOST_PLANES};

/// What the numbers of a group must respect.
#[derive(Copy, Clone, Debug)]
pub struct Limits<'a> {
    /// Blocks of the group.
    pub blocks: u32,
    /// Bits of a code.
    pub code_bits: u32,
    /// Codewords of each codebook, in their order.
    pub codewords: &'a [u32],
    /// Greatest code of a mean.
    pub greatest_mean: u32,
}

/// Whether every number of a group stays within its frame and its codebooks, and every sum within 32 bits.
///
/// # Errors
/// A sentence about the first number that does not.
pub fn check(frame: &Groups<'_>, group: usize, limits: &Limits<'_>) -> Result<(), String> {
    let head = frame.head(group);
    let length = frame.words.len() as u64;
    if head.base > limits.greatest_mean {
        return Err(format!("a mean of code {}", head.base));
    }
    if head.records == Records::None {
        return Ok(());
    }
    if head.mean_bits > MOST_BITS || head.planes > MOST_PLANES {
        return Err(format!("means of {} bits and {} planes", head.mean_bits, head.planes));
    }
    if head.base + ((1 << head.mean_bits) - 1) > limits.greatest_mean {
        return Err(format!("a mean of code {}", head.base + ((1 << head.mean_bits) - 1)));
    }
    let bits_of = |first: u64, words: u64| -> Result<u64, String> {
        if first + words > length {
            return Err(format!("planes end at word {}", first + words));
        }
        let word = |i: u64| u64::from(frame.words[(first + i) as usize]);
        Ok(if words == 2 { word(0) | word(1) << 32 } else { word(0) })
    };
    let within = |count: u32| if count == BLOCKS { u64::MAX } else { (1 << count) - 1 };
    let mut first = u64::from(head.start);
    let mut records = limits.blocks;
    if head.records == Records::Named {
        let mask = bits_of(first, 2)?;
        if mask & !within(limits.blocks) != 0 {
            return Err(format!("a record of a block beyond the {} of the group", limits.blocks));
        }
        records = mask.count_ones();
        first += 2;
    }
    let size = u64::from(plane_words(records));
    let mut counts = [0_u32; BLOCKS as usize];
    for j in 0..head.planes {
        let plane = bits_of(first, size)?;
        (0..records).for_each(|n| counts[n as usize] |= ((plane >> n & 1) as u32) << j);
        first += size;
    }
    if let Some([least, planes]) = head.escapes {
        let escaped = bits_of(first, size)?;
        if escaped & !within(records) != 0 {
            return Err(format!("an escape beyond the {records} records of the group"));
        }
        first += size;
        let count = escaped.count_ones();
        let size = u64::from(plane_words(count));
        let mut widths = [least; BLOCKS as usize];
        for _ in 0..planes {
            bits_of(first, size)?;
            first += size;
        }
        for j in 0..planes {
            let plane = bits_of(first - size * u64::from(planes - j), size)?;
            (0..count).for_each(|n| widths[n as usize] += ((plane >> n & 1) as u32) << j);
        }
        let mut end = u64::from(head.start);
        for bits in &widths[..count as usize] {
            let words = u64::from(frame.parts * part_words(*bits));
            let begin = end.checked_sub(words).filter(|_| end <= length && *bits <= MOST_BITS);
            let begin = begin.ok_or_else(|| format!("an escape of {bits} bits ends at word {end}"))?;
            for part in 0..frame.parts {
                if !fits(frame.words, begin as u32 + part * part_words(*bits), *bits) {
                    return Err(format!("the step of an escape of {bits} bits is too large"));
                }
            }
            end = begin;
        }
    }
    if first > length {
        return Err(format!("planes end at word {first}"));
    }
    let end = (length - first) * 32;
    let mut bit = u64::from(records * head.mean_bits);
    for count in &counts[..records as usize] {
        let codes = u64::from(*count) * u64::from(limits.code_bits);
        if *count as usize > limits.codewords.len() || bit + codes > end {
            return Err(format!("a block keeps {count} codes"));
        }
        for codewords in &limits.codewords[..*count as usize] {
            if crate::number(frame.words, first as u32, bit, limits.code_bits) >= *codewords {
                return Err(format!("a block names a codeword of {codewords}"));
            }
            bit += u64::from(limits.code_bits);
        }
    }
    if bit > end {
        return Err(format!("means end at bit {bit}"));
    }
    Ok(())
}
