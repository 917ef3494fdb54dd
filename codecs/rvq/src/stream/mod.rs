//! What a stream holds: decode parameters, and where codes and entries of codewords lie. It names no other room.

mod entries;
mod geometry;

use cvr_core::codec::Block;
use cvr_core::volume::Extent;
use cvr_groups::VALUE_BITS;
use serde::{Deserialize, Serialize};

pub use entries::Entries;
pub use geometry::{Geometry, Parameters, Table, TrainingRecord};

/// Tensor and shader resource: the codewords.
pub const CODEBOOK: &str = "codebook";
/// Tensor and shader resource: the codes of all blocks; under the payload `variable` groups.
pub const INDEX: &str = "index";
/// Tensor and shader resource: where the means and codes of each group begin, under the payload `variable`.
pub const HEADS: &str = "heads";
/// Voxels along each axis of a block.
pub const EDGE: u32 = 4;
/// Blocks of 4³, 2³ and 1³ voxels.
pub const RESOLUTIONS: usize = 3;
/// Most stages of a stream.
pub const MOST_STAGES: u32 = 16;
/// Most codewords of a stage.
pub const MOST_CODEWORDS: u32 = 1 << 16;
/// The sum of no codeword, the middle of all values.
pub const BASE: i32 = 1 << (VALUE_BITS - 1);
/// Largest value before it is scaled to data units.
pub const TOP: i32 = (1 << VALUE_BITS) - 1;

/// What a mean's code stands for, for each channel: five bits of each of three colours, or a multiple of 2^`mean_shift`.
#[must_use]
#[inline]
pub const fn decoded_mean(channels: u32, mean_shift: u32, code: u32) -> [i32; 3] {
    if channels == 3 {
        let step = COLOUR_MEAN as i32;
        return [(code & 31) as i32 * step, (code >> 5 & 31) as i32 * step, (code >> 10) as i32 * step];
    }
    [(code << mean_shift) as i32, 0, 0]
}

/// A block at a resolution: 4³ voxels, 2³ or one.
#[must_use]
pub fn block(resolution: usize) -> Block {
    Block(Extent::cube(EDGE >> resolution).unwrap_or(Extent::ONE))
}
/// Steps of a colour's mean under the payload `variable`: 31 of them reach from 0 to all but 2 of the greatest value.
pub const COLOUR_MEAN: u32 = 2114;
/// Greatest code of the means of three colours, 5 bits each, and one more: a group's bits may reach beyond its greatest mean.
pub const GREATEST_COLOURS: u32 = (1 << 16) - 1;

/// What a block stores.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Payload {
    /// One code of each stage.
    Fixed,
    /// A mean, as many codes as pay, and what is coded directly.
    Variable,
}
