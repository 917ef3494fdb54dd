//! A lower resolution of a volume, drawn at the volume's size.
//!
//! Voxel `i` of resolution `r` covers the volume's voxels `i · 2^r .. (i + 1) · 2^r` along each axis. Its centre lies
//! at `(i + ½) · 2^r`, even if the volume ends before. All scale factors are powers of two, so scaling is exact:
//! pictures of all resolutions have the same box, camera and step.

use glam::DVec3;

use super::{Camera, RayFrame};
use crate::volume::{Extent, Level, VolumeLayout};

/// The volume whose lower resolution is drawn.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Coarse {
    extent: Extent,
    resolution: u8,
}

impl Coarse {
    /// A resolution of a volume of this shape. `None` for the full resolution.
    #[must_use]
    pub fn of(volume: &VolumeLayout, resolution: u8) -> Option<Self> {
        (resolution > 0).then_some(Self { extent: volume.extent, resolution })
    }

    /// Voxels of the volume.
    #[must_use]
    pub const fn extent(&self) -> Extent {
        self.extent
    }

    /// Voxels of the volume per voxel of the resolution, along each axis.
    #[must_use]
    pub fn scale(&self) -> f32 {
        Level::scale(self.resolution) as f32
    }

    /// The rays of a picture of the volume, in voxel coordinates of the resolution, whose shape is `layout`. World
    /// lengths are the volume's: its smallest spacing is their unit.
    pub(super) fn rays(&self, camera: &Camera, layout: &VolumeLayout, size: [u32; 2]) -> RayFrame {
        let spacing = DVec3::from_array(layout.spacing) / Level::scale(self.resolution);
        let volume = VolumeLayout { extent: self.extent, spacing: spacing.to_array(), ..layout.clone() };
        let rays = camera.rays(&volume, size);
        let scale = self.scale();
        RayFrame {
            origin: rays.origin / scale,
            origin_right: rays.origin_right / scale,
            origin_up: rays.origin_up / scale,
            direction: rays.direction / scale,
            direction_right: rays.direction_right / scale,
            direction_up: rays.direction_up / scale,
            voxel_size: rays.voxel_size * scale,
            pixel: rays.pixel,
        }
    }
}

#[cfg(test)]
mod tests;
