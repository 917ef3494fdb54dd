//! The words of a range coder as bytes.

use constriction::{Queue, backends::ReadWords};

use super::fault::Fault;

/// Big-endian bytes of the words of an encoder whose state is `lower` and `range`. The first `decided` words are whole.
/// Of the others, there are as many bytes as tell the last interval from all others, if zeros follow.
#[must_use]
pub fn bytes(mut words: Vec<u32>, decided: usize, lower: u64, range: u64) -> Vec<u8> {
    if let Some(last) = words.get_mut(decided) {
        *last = roundest(*last, lower, range);
    }
    let mut bytes = words.iter().copied().flat_map(u32::to_be_bytes).collect::<Vec<_>>();
    while bytes.len() > 4 * decided && bytes.last() == Some(&0) {
        bytes.pop();
    }
    bytes
}

/// The upper word of the number with the most zeros at its end that lies within `range` numbers from `lower` on.
/// `word` is such a number too; one that is smaller has overflowed, and the words before it are already decided.
fn roundest(word: u32, lower: u64, range: u64) -> u32 {
    let round = |bits: u32| lower.wrapping_add((1 << bits) - 1) >> bits << bits;
    let within = |number: &u64| number.wrapping_sub(lower) < range && *number >= u64::from(word) << 32;
    (32..64).rev().map(round).find(within).map_or(word, |number| (number >> 32) as u32)
}

/// A decoder is two words ahead of the words that its encoder has decided.
const LAST: usize = 8;

/// Words of a stream, and zeros after its end: no more than an encoder can have left out.
#[derive(Debug)]
pub struct Words<'a> {
    bytes: &'a [u8],
    /// The last of all bytes.
    last: u8,
    /// How many zeros have been read after the end.
    past: usize,
}

impl<'a> Words<'a> {
    /// All words of a stream.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, last: bytes.last().copied().unwrap_or(0), past: 0 }
    }

    /// Checks that no bytes are left.
    ///
    /// # Errors
    /// There are, or a zero that [`bytes()`] leaves out.
    pub fn finish(self) -> Result<(), Fault> {
        let zeros = self.past < LAST && self.last == 0;
        if self.bytes.is_empty() && !zeros { Ok(()) } else { Err(Fault("bytes follow the last symbol")) }
    }

    #[cold]
    fn padded(&mut self) -> Result<u32, Fault> {
        let rest = std::mem::take(&mut self.bytes);
        self.past += 4 - rest.len();
        if self.past > LAST {
            return Err(Fault("bytes end before the last symbol"));
        }
        Ok(rest.iter().zip([24, 16, 8]).fold(0, |word, (byte, shift)| word | u32::from(*byte) << shift))
    }
}

impl ReadWords<u32, Queue> for Words<'_> {
    type ReadError = Fault;

    #[inline]
    fn read(&mut self) -> Result<Option<u32>, Fault> {
        match self.bytes.split_first_chunk() {
            Some((word, rest)) => {
                self.bytes = rest;
                Ok(Some(u32::from_be_bytes(*word)))
            }
            None => self.padded().map(Some),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_word_is_as_round_as_its_interval_allows() {
        let top = |words: u64| words << 32;
        assert_eq!(roundest(0x1234_5679, top(0x1234_5678) + 1, top(0x10)), 0x1234_5680);
        assert_eq!(roundest(0x1234_5679, top(0x1234_5678) + 1, top(4)), 0x1234_567c);
        assert_eq!(roundest(0x1234_5678, top(0x1234_5678), top(1)), 0x1234_5678);
        assert_eq!(roundest(1, 1, top(u64::from(u32::MAX))), 0x8000_0000);
        // 2^64 would be rounder, but its carry would change the words before.
        assert_eq!(roundest(0xffff_fff1, top(0xffff_fff0) + 1, top(0x20)), 0xffff_fff8);
    }

    #[test]
    fn zeros_at_the_end_are_left_out_but_not_of_decided_words() {
        assert_eq!(bytes(vec![], 0, 0, u64::MAX).len(), 0);
        assert_eq!(bytes(vec![0x0100_0000, 5, 0], 1, (4 << 32) + 1, 1 << 32), [1, 0, 0, 0, 0, 0, 0, 5]);
        assert_eq!(bytes(vec![7, 0x1234_5679], 1, (0x1234_5678 << 32) + 1, 1 << 56), [0, 0, 0, 7, 0x13]);
        assert_eq!(bytes(vec![0x0100_0000, 0], 1, 0, 1 << 32), [1, 0, 0, 0]);
    }

    #[test]
    fn a_decoder_reads_two_words_of_zeros_but_not_three() {
        let mut words = Words::new(&[1, 2, 3, 4, 5]);
        assert_eq!(words.read(), Ok(Some(0x0102_0304)));
        assert_eq!(words.read(), Ok(Some(0x0500_0000)));
        assert_eq!(words.read(), Ok(Some(0)));
        assert!(words.read().is_err());
        assert!(Words::new(&[1]).finish().is_err());
    }
}
