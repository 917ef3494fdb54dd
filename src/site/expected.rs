//! The CPU's decoded frame, and comparisons with it.

use std::sync::Arc;

use cvr_core::codec::{Agreement, Block, Decoder, Parity};
use cvr_core::render::DecodedFrame;
use cvr_core::volume::{FrameIndex, Level};

use super::coded::CodedFrame;

/// A frame of a stream at a level, decoded by the CPU.
#[derive(Clone, Debug)]
pub struct Expected<'a> {
    /// Codec id.
    pub codec: &'a str,
    /// The opened stream.
    pub decoder: &'a dyn Decoder,
    /// The frame's place in it.
    pub key: (FrameIndex, Level),
    /// The frame that the CPU decoded.
    pub frame: Arc<DecodedFrame>,
    /// The codec's block, if it has one. The report of a mismatch names it.
    pub block: Option<Block>,
}

impl<'a> Expected<'a> {
    /// The same frame, not decoded.
    #[must_use]
    pub const fn coded(&self) -> CodedFrame<'a> {
        CodedFrame { codec: self.codec, decoder: self.decoder, key: self.key }
    }

    /// Compares `values` of the whole frame. `agreement` is the tolerance. `what` names the values, followed by a verb.
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
    /// Number of samples outside the agreement.
    pub mismatches: u64,
    /// The largest distance over all samples, in data units.
    pub largest: f64,
    /// A sentence about the first mismatch. `None` if all samples agree.
    pub problem: Option<String>,
    /// A remark for the record if all samples agree.
    pub remark: Option<String>,
}

impl Checked {
    /// Joins two results. Of two problems the first is kept.
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
