//! A lower resolution of a volume, drawn at the volume's size.
//!
//! Voxel `i` of resolution `r` covers the volume's voxels `i · 2^r .. (i + 1) · 2^r` along each axis, and its centre lies at
//! `(i + ½) · 2^r`, also where the volume ends before. All scaling is by powers of two, and exact: pictures of all
//! resolutions are of one box, camera and step.

use glam::DVec3;
use rayon::prelude::*;

use super::mirror::trilinear;
use super::{Camera, DecodedFrame, RayFrame};
use crate::memory::{self, OutOfMemory};
use crate::volume::{Extent, Level, VolumeLayout};

/// The volume of which a lower resolution is drawn.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Coarse {
    extent: Extent,
    resolution: u8,
}

impl Coarse {
    /// A resolution of a volume of this shape; `None` of the full one.
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

    /// The rays of a picture of the volume, in coordinates of the resolution's voxels, whose shape is `layout`. World
    /// lengths are those of the volume: its smallest spacing is their unit.
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

/// A frame of a lower resolution at every voxel centre of its volume, which has `extent` voxels: what the filter *linear*
/// samples there. Of voxel errors of a resolution, this is what the volume is compared with.
///
/// # Errors
/// When there is no memory for it.
pub fn upsampled(frame: &DecodedFrame, extent: Extent, resolution: u8) -> Result<Vec<f32>, OutOfMemory> {
    let channels = frame.layout().channels as usize;
    let coarse = frame.layout().extent;
    let samples = extent.voxels() * channels as u64;
    let mut out: Vec<f32> = memory::zeroed(samples, || format!("a frame brought to {extent} voxels"))?;
    let scale = Level::scale(resolution) as f32;
    // Per axis and voxel: the two voxels around its centre, clamped at the border, and its place between them.
    let [x, y, z] = [0, 1, 2].map(|a| {
        let last = i64::from(coarse.to_array()[a]) - 1;
        let around = |i: u32| {
            let at = (i as f32 + 0.5) / scale - 0.5;
            let below = at.floor() as i64;
            let clamped = |i: i64| i.clamp(0, last) as u32;
            (clamped(below), clamped(below + 1), at - at.floor())
        };
        (0..extent.to_array()[a]).map(around).collect::<Vec<_>>()
    });
    let slice = x.len() * y.len() * channels;
    out.par_chunks_mut(slice).zip(&z).for_each(|(out, &(z0, z1, tz))| {
        let rows = out.chunks_mut(x.len() * channels).zip(&y);
        for (row, &(y0, y1, ty)) in rows {
            for (voxel, &(x0, x1, tx)) in row.chunks_mut(channels).zip(&x) {
                for (c, value) in voxel.iter_mut().enumerate() {
                    let at = |p: [u32; 3]| frame.values()[coarse.index(p) * channels + c];
                    let corner = |i: usize| {
                        let choose = |bit: usize, a, b| if i >> bit & 1 == 0 { a } else { b };
                        at([choose(0, x0, x1), choose(1, y0, y1), choose(2, z0, z1)])
                    };
                    *value = trilinear(std::array::from_fn(corner), glam::Vec3::new(tx, ty, tz));
                }
            }
        }
    });
    Ok(out)
}

#[cfg(test)]
mod tests;
