//! Blocks that are transformed on their own, so that a shader decodes any voxel.
//!
//! README.md specifies the stream. An encoder reads blocks (`rows`), transforms (`lift`) and quantises them
//! (`quantise`), sorts the places of a group into classes (`classes`) and writes them (`write`). `target` finds
//! the step. [`decode`] and its twins in WGSL read voxels; `reader` checks a stream once.

mod bits;
mod classes;
pub mod decode;
mod encode;
mod lift;
mod quantise;
mod reader;
mod rows;
mod scale;
mod shape;
mod sizes;
mod target;
mod write;

use serde::{Deserialize, Serialize};

pub use encode::encode;
pub use reader::Reader;
pub use scale::Scale;
pub use shape::Parameters;

/// Tensor and shader resource: an entry per block.
const TABLE: &str = "table";
/// Tensor and shader resource: the bits of all blocks.
const BITS: &str = "bits";

/// A pair of filters: low-pass and high-pass.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Filter {
    /// Means and differences of two samples: the S-transform, which is Haar's in integers.
    #[serde(rename = "haar")]
    Haar,
    /// Five and three samples: the reversible filters of JPEG 2000 (Le Gall and Tabatabai 1988).
    #[serde(rename = "5-3")]
    FiveThree,
}

/// What a stream is encoded to.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Target {
    /// Every sample as it is. Integers only.
    Lossless,
    /// At most so many bits per voxel of the whole file, all channels together. Less than 1 % below it, unless the volume
    /// is lossless with less.
    BitsPerVoxel(f64),
    /// At least this PSNR in dB, with as few bits as the step allows.
    Psnr(f64),
    /// No sample errs by more than this, in data units.
    MaxError(f64),
}

/// Settings of the encoder.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Options {
    /// Voxels along each axis of a block: 8 or 16.
    pub block: u32,
    /// The filters.
    pub filter: Filter,
    /// What to aim at.
    pub target: Target,
}
