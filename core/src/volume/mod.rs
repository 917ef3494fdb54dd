//! Volumes: layouts, samples, boxes, and sources of voxels.
//!
//! Conventions of the whole project: x is fastest in memory; channels of one voxel are adjacent; values are *data
//! units* as `f32` (every 8- and 16-bit integer is exact).

mod axis;
mod brick;
mod dense;
mod extent;
mod finite;
mod layout;
mod level;
mod range;
mod sample;
mod source;
mod stored;

pub use axis::Axis;
pub use brick::{BrickKey, Region};
pub use dense::{DenseVolume, Samples};
pub use extent::{Extent, ExtentError};
pub use finite::{FiniteVolume, Replaced};
pub use layout::{FrameIndex, LayoutError, VolumeLayout};
pub use level::Level;
pub use range::ValueRange;
pub use sample::SampleType;
pub use source::{BrickSource, Dependencies, NoReferences, ReferenceFrames, SourceError};
pub use stored::StoredType;
