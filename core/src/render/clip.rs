//! The clip box. Voxels outside are not drawn.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::volume::Extent;

/// A box within the volume, as fractions of its extent: 0 is the lower face, 1 the upper one.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClipBox {
    /// Lower corner, `0.0..1.0`.
    pub low: [f32; 3],
    /// Upper corner, above the lower one and at most 1.
    pub high: [f32; 3],
}

impl ClipBox {
    /// The whole volume.
    pub const WHOLE: Self = Self { low: [0.0; 3], high: [1.0; 3] };

    /// The first axis along which the box is empty: its upper corner is not above its lower one.
    #[must_use]
    pub fn empty_axis(&self) -> Option<usize> {
        self.low.iter().zip(&self.high).position(|(low, high)| low >= high)
    }

    /// Lower and upper corner in voxel coordinates.
    #[must_use]
    pub fn corners(&self, extent: Extent) -> [Vec3; 2] {
        let extent = Vec3::from_array(extent.to_array().map(|e| e as f32));
        [self.low, self.high].map(|corner| Vec3::from_array(corner) * extent)
    }
}
