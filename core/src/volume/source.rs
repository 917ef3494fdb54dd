//! Sources of voxels: bricks of an input volume, and decoded frames.

use super::{FrameIndex, Region, VolumeLayout};

/// Why a brick could not be read.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// The box does not lie inside the volume, or the frame does not exist.
    #[error("region at {origin:?} of {extent} in frame {frame} lies outside the volume")]
    OutOfBounds {
        /// Lowest voxel asked for.
        origin: [u32; 3],
        /// Size asked for.
        extent: super::Extent,
        /// Frame asked for.
        frame: u32,
    },
    /// The file behind the source failed.
    #[error("reading voxels failed: {0}")]
    Io(#[from] std::io::Error),
}

/// A volume that returns boxes of voxels. An encoder reads its input only through it, so a volume need not fit into
/// memory.
pub trait BrickSource: Sync {
    /// Shape of the volume.
    fn layout(&self) -> &VolumeLayout;

    /// Fills `out` (region voxels × channels; x fastest, channels interleaved) with data values.
    ///
    /// # Errors
    /// When the region lies outside or the underlying file fails.
    ///
    /// # Panics
    /// When `out` has not exactly region voxels × channels elements.
    fn read(&self, frame: FrameIndex, region: Region, out: &mut [f32]) -> Result<(), SourceError>;
}

/// Frames that must be decoded before a frame can be.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Dependencies {
    /// None: decodes on its own.
    Intra,
    /// One other frame, usually an earlier one.
    Predicted(FrameIndex),
    /// Two other frames, usually an earlier and a later one.
    Bidirectional(FrameIndex, FrameIndex),
}

impl Dependencies {
    /// The frames, in the order in which they stand here.
    #[must_use]
    pub const fn frames(self) -> [Option<FrameIndex>; 2] {
        match self {
            Self::Intra => [None, None],
            Self::Predicted(frame) => [Some(frame), None],
            Self::Bidirectional(first, second) => [Some(first), Some(second)],
        }
    }
}

/// Decoded frames for a decoder of predicted frames. All have the level of the decoded frame.
pub trait ReferenceFrames: Sync {
    /// All decoded samples of `frame` (x fastest, channels interleaved). `None` if the frame is not available.
    fn frame(&self, frame: FrameIndex) -> Option<&[f32]>;
}

/// No references. Frames that decode on their own need none.
#[derive(Copy, Clone, Debug, Default)]
pub struct NoReferences;

impl ReferenceFrames for NoReferences {
    fn frame(&self, _: FrameIndex) -> Option<&[f32]> {
        None
    }
}
