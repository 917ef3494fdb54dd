//! A lower resolution of a volume, drawn at the volume's size.
//!
//! Voxel `i` of resolution `r` covers the volume's voxels `i · 2^r .. (i + 1) · 2^r` along each axis. Its centre lies
//! at `(i + ½) · 2^r`, even if the volume ends before, unless its codec shifts it ([`crate::codec::Decoder::coarse_shift`]).
//! All scale factors are powers of two, so scaling is exact: pictures of all resolutions have the same camera and step,
//! and the same box, which ends where shifted voxels do.

use glam::{DVec3, Vec3};

use super::{Camera, RayFrame};
use crate::volume::{Extent, Level, VolumeLayout};

/// The volume whose lower resolution is drawn.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Coarse {
    extent: Extent,
    resolution: u8,
    shift: f32,
}

impl Coarse {
    /// A resolution of a volume of this shape, whose voxels are shifted. `None` for the full resolution.
    #[must_use]
    pub fn of(volume: &VolumeLayout, resolution: u8, shift: f32) -> Option<Self> {
        (resolution > 0).then_some(Self { extent: volume.extent, resolution, shift })
    }

    /// A corner of a box of the volume, in voxel coordinates of the resolution, which has `voxels`.
    pub(super) fn corner(&self, corner: Vec3, voxels: Extent) -> Vec3 {
        let most = Vec3::from_array(voxels.to_array().map(|n| n as f32));
        (corner / self.scale() + self.shift).clamp(Vec3::ZERO, most)
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
            origin: rays.origin / scale + self.shift,
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
