//! Storage of a block's minimum and maximum: in the sample's own type, so that they are exact.

use cvr_core::volume::SampleType;

/// Storage of an endpoint. An *entry* is a minimum in the low and a maximum in the high half of its bits.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// Bits of one endpoint: 8, 16 or 32 (the bit pattern of a single).
    pub bits: u32,
    /// Whether integers are in two's complement.
    pub signed: bool,
}

impl Endpoint {
    /// The storage for samples of this type.
    #[must_use]
    pub fn new(sample: SampleType) -> Self {
        Self { bits: sample.bits(), signed: sample.integer_range().is_some_and(|(low, _)| low < 0) }
    }

    /// Bits of one entry.
    #[must_use]
    pub const fn entry_bits(self) -> u32 {
        2 * self.bits
    }

    /// Whether samples are integers.
    #[must_use]
    pub const fn is_integer(self) -> bool {
        self.bits < 32
    }

    /// The code of an endpoint, in the low bits.
    #[must_use]
    pub fn code(self, value: f32) -> u32 {
        if self.bits == 32 {
            return value.to_bits();
        }
        value as i32 as u32 & (u32::MAX >> (32 - self.bits))
    }
}

/// Packs entries into words, one after another. An entry of 16 bits is held until its neighbour comes.
#[derive(Debug)]
pub struct EntryPacker {
    endpoint: Endpoint,
    waiting: Option<u32>,
}

impl EntryPacker {
    pub const fn new(endpoint: Endpoint) -> Self {
        Self { endpoint, waiting: None }
    }

    /// Appends one entry.
    pub fn push(&mut self, low: f32, high: f32, words: &mut Vec<u32>) {
        let (low, high) = (self.endpoint.code(low), self.endpoint.code(high));
        match self.endpoint.bits {
            32 => words.extend([low, high]),
            16 => words.push(low | high << 16),
            _ => {
                let entry = low | high << 8;
                match self.waiting.take() {
                    Some(first) => words.push(first | entry << 16),
                    None => self.waiting = Some(entry),
                }
            }
        }
    }

    /// Ends a frame: an entry that still waits gets a zero neighbour.
    pub fn flush(&mut self, words: &mut Vec<u32>) {
        words.extend(self.waiting.take());
    }
}
