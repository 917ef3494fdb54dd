//! What sites are held to: a frame as the CPU decodes it, and what comparing with it has found.

use std::sync::Arc;

use cvr_core::codec::{Agreement, Block, Decoder, Parity};
use cvr_core::render::DecodedFrame;
use cvr_core::volume::{FrameIndex, Level};

use super::coded::CodedFrame;

/// A frame of a stream at a level as the CPU decodes it.
#[derive(Clone, Debug)]
pub struct Expected<'a> {
    /// Codec id.
    pub codec: &'a str,
    /// The opened stream.
    pub decoder: &'a dyn Decoder,
    /// The frame's place in it.
    pub key: (FrameIndex, Level),
    /// What the CPU decodes.
    pub frame: Arc<DecodedFrame>,
    /// The codec's block, if it has one: the report of a mismatch names it.
    pub block: Option<Block>,
}

impl<'a> Expected<'a> {
    /// The same frame, not decoded.
    #[must_use]
    pub const fn coded(&self) -> CodedFrame<'a> {
        CodedFrame { codec: self.codec, decoder: self.decoder, key: self.key }
    }

    /// Compares `values` of the whole frame under a statement; `what` names them, with their verb.
    #[must_use]
    pub fn compare(&self, what: &str, agreement: Agreement, values: &[f32]) -> Checked {
        let parity = Parity::compare_at(self.decoder, agreement, self.key, self.frame.values(), values);
        let problem = || format!("{what} is not what the CPU decodes: {}", parity.with_block(self.block));
        let Parity { mismatches, largest, .. } = parity;
        Checked { mismatches, largest, problem: (!parity.holds()).then(problem), remark: None }
    }
}

/// What comparing has found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checked {
    /// Samples beyond what is stated.
    pub mismatches: u64,
    /// The largest distance of any sample, in data units.
    pub largest: f64,
    /// What is wrong, with the first mismatch in words; `None` where all agree.
    pub problem: Option<String>,
    /// What a record notes although all agree.
    pub remark: Option<String>,
}

impl Checked {
    /// Both together; of two problems the first counts.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let first = self.largest > other.largest || self.largest.is_nan();
        Self {
            mismatches: self.mismatches + other.mismatches,
            largest: if first { self.largest } else { other.largest },
            problem: self.problem.or(other.problem),
            remark: self.remark.or(other.remark),
        }
    }
}
