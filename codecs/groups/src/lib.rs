//! Groups of 4×4×4 blocks under the payload `variable`: one format for all codecs whose blocks keep as many codes as they need.
//!
//! README.md in this folder describes the words. [`Writer`] writes them, [`Groups`] reads them, [`check`] proves that no
//! number leads outside, and `groups.wgsl` ([`snippet`]) is the reader's twin. [`Tally`] says how many words a group takes before
//! it is written. [`Plan`] and [`settle`] decide what each block keeps. The crate knows no codec.

mod bits;
mod check;
mod choice;
mod escape;
mod expected;
mod fit;
mod head;
mod kept;
mod plan;
mod rate_control;
mod read;
mod scale;
mod tally;
#[cfg(test)]
mod tests;
mod ways;
mod write;

pub use bits::{Bits, mean_width, number};
pub use check::{Limits, check};
pub use choice::{Candidate, Choice, best, escape_bits};
pub use escape::{Escape, part_range, part_value, part_words};
pub use expected::{Direct, Expected};
pub use fit::Rest;
pub use head::{Head, Records};
pub use kept::KeptPlane;
pub use plan::{CodedBlocks, Plan, Plane};
pub use rate_control::{Aim, Settled, Sum, settle, settle_all};
pub use read::{Block, Groups};
pub use scale::{Scale, VALUE_BITS};
pub use tally::Tally;
pub use ways::{Prices, Ways};
pub use write::{Codes, Writer};

/// Blocks along each axis of a group that no border cuts.
pub const EDGE: u32 = 4;
/// Most blocks of a group.
pub const BLOCKS: u32 = EDGE * EDGE * EDGE;
/// Words of a head.
pub const HEAD_WORDS: u32 = 2;
/// Most bits of a block's count of codes.
pub const MOST_PLANES: u32 = 6;
/// Most bits of a mean, of a code, and of a voxel that is coded directly.
pub const MOST_BITS: u32 = 16;
/// Voxels of a block.
pub const VOXELS: usize = 64;

/// A codec's snippet with the functions of `groups.wgsl` behind it, under the codec's prefix.
///
/// The codec declares the resources `index` and `heads` and the constant `parts`: numbers that an escape has for each place
/// of a block, 1 or one for each channel.
#[must_use]
pub fn snippet(codec: &str, own: &str) -> String {
    format!("{own}\n{}", include_str!("groups.wgsl").replace("groups_", &format!("{codec}_")))
}
