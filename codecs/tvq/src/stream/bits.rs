//! Numbers of any width in words.

/// Numbers of any width, packed without gaps, lowest bits first.
#[derive(Debug, Default)]
pub struct Bits {
    pub words: Vec<u32>,
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

/// The code from which some means are counted, and the bits of each.
#[must_use]
pub fn mean_width(means: &[u32]) -> (u32, u32) {
    let (low, high) = means.iter().fold((u32::MAX, 0), |(low, high), m| (low.min(*m), high.max(*m)));
    let low = low.min(high);
    (low, 32 - (high - low).leading_zeros())
}
