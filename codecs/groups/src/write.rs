//! A frame's groups into words.

use crate::bits::Bits;
use crate::escape::part_words;
use crate::head::{Head, Records, plane_words, planes_of};
use crate::tally::Tally;

/// What a block keeps.
#[derive(Copy, Clone, Debug)]
pub struct Codes<'a> {
    /// Code of its mean.
    pub mean: u32,
    /// Its codes, of codebook 0 on.
    pub codes: &'a [u16],
    /// Words of all parts of its escape; none where it has no escape.
    pub escape: &'a [u32],
}

/// A frame's groups, one after the other.
#[derive(Debug)]
pub struct Writer {
    parts: u32,
    heads: Vec<u32>,
    words: Vec<u32>,
}

/// Bits `each` says, in the words of a plane.
fn plane(bits: impl ExactSizeIterator<Item = bool>) -> impl Iterator<Item = u32> {
    let count = plane_words(bits.len() as u32) as usize;
    let mut words = [0_u32; 2];
    bits.enumerate().for_each(|(i, bit)| words[i / 32] |= u32::from(bit) << (i % 32));
    words.into_iter().take(count)
}

impl Writer {
    /// No group yet; escapes have so many parts.
    #[must_use]
    pub const fn new(parts: u32) -> Self {
        Self { parts, heads: Vec::new(), words: Vec::new() }
    }

    /// Bits of a voxel of an escape.
    const fn escape_bits(&self, words: &[u32]) -> u32 {
        (words.len() as u32 / self.parts - part_words(0)) / (part_words(1) - part_words(0))
    }

    /// What some blocks come to.
    fn tally(&self, blocks: &[Codes<'_>], base: u32) -> Tally {
        let mut tally = Tally::default();
        for block in blocks {
            let escape = (!block.escape.is_empty()).then(|| self.escape_bits(block.escape));
            tally.add(block.mean == base, block.codes.len() as u32, escape);
        }
        tally
    }

    /// Appends a group of at most 64 blocks, x fastest. Their means lie from `base` on within `mean_bits` bits. `None` where the
    /// frame exceeds 2^32 words.
    pub fn push(
        &mut self,
        blocks: &[Codes<'_>],
        (base, mean_bits): (u32, u32),
        code_bits: u32,
    ) -> Option<()> {
        let tally = self.tally(blocks, base);
        let count = tally.records(mean_bits, code_bits, self.parts);
        let records = match count {
            0 => Records::None,
            count if count == tally.blocks => Records::All,
            _ => Records::Named,
        };
        let bare =
            |block: &&Codes<'_>| block.mean == base && block.codes.is_empty() && block.escape.is_empty();
        let kept: Vec<&Codes<'_>> = blocks.iter().filter(|b| records == Records::All || !bare(b)).collect();
        let escaped: Vec<&&Codes<'_>> = kept.iter().filter(|b| !b.escape.is_empty()).collect();
        // The escape of the first escaped block is nearest to the group's first word.
        escaped.iter().rev().for_each(|block| self.words.extend(block.escape));
        let start = u32::try_from(self.words.len()).ok()?;
        let planes = planes_of(tally.most_codes);
        let [least, most] = tally.escape_range;
        let escapes = (tally.escapes > 0).then(|| [least, planes_of(most - least)]);
        let mean_bits = if records == Records::None { 0 } else { mean_bits };
        self.heads.extend(Head { start, base, mean_bits, records, planes, escapes }.words());
        if records == Records::None {
            return Some(());
        }
        if records == Records::Named {
            let mut mask = [0_u32; 2];
            let named = blocks.iter().enumerate().filter(|(_, b)| !bare(b));
            named.for_each(|(n, _)| mask[n / 32] |= 1 << (n % 32));
            self.words.extend(mask);
        }
        for j in 0..planes {
            self.words.extend(plane(kept.iter().map(|b| b.codes.len() >> j & 1 == 1)));
        }
        if let Some([least, planes]) = escapes {
            self.words.extend(plane(kept.iter().map(|b| !b.escape.is_empty())));
            for j in 0..planes {
                let bit = |b: &&&Codes<'_>| (self.escape_bits(b.escape) - least) >> j & 1 == 1;
                let words: Vec<u32> = plane(escaped.iter().map(bit)).collect();
                self.words.extend(words);
            }
        }
        let mut bits = Bits::default();
        kept.iter().for_each(|block| bits.push(block.mean - base, mean_bits));
        for code in kept.iter().flat_map(|block| block.codes) {
            bits.push((*code).into(), code_bits);
        }
        self.words.extend(bits.finish());
        Some(())
    }

    /// Words of all groups so far.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.words.len()
    }

    /// Whether no group has words.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// Heads and words, and one word 0 behind the last.
    #[must_use]
    pub fn finish(mut self) -> (Vec<u32>, Vec<u32>) {
        self.words.push(0);
        (self.heads, self.words)
    }
}
