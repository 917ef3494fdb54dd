//! The decode parameters of a stream of whole volumes, and its tensors.

use cvr_core::volume::ValueRange;
use serde::{Deserialize, Serialize};

use crate::coders::Coding;
use crate::quantiser::Scale;
use crate::transform::Filter;

/// All chunks of all frames and channels, as bytes, and one byte of 0, so that there is always one.
pub const CHUNKS: &str = "chunks";
/// Bytes of each chunk, by frame and channel.
pub const LENGTHS: &str = "lengths";
/// The step of each frame and channel.
pub const STEPS: &str = "steps";

/// Most decompositions that a stream may have.
pub const MOST_DECOMPOSITIONS: u32 = 12;

/// What the JSON of a container holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Whole volumes.
    pub mode: Mode,
    /// Voxels along x, y and z. They equal the volume's, whose coefficients of another shape would be others.
    pub extent: [u32; 3],
    /// Filter of the transform.
    pub filter: Filter,
    /// Number of decompositions.
    pub decompositions: u32,
    /// Entropy coder.
    pub coder: Coding,
    /// The paper's quantiser, if it was used. Otherwise steps follow from the tensor [`STEPS`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paper: Option<(u8, Scale)>,
    /// Unit of corrections, in data units. With it, each channel of a frame has one more chunk.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correction: Option<f32>,
    /// Range of the samples before encoding. Decoded samples are clamped to it.
    pub range: ValueRange,
}

/// The mode of a stream.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Whole volumes.
    Volume,
    /// Blocks that decode on their own.
    Blocks,
}
