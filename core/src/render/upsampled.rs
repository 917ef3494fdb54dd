//! A frame of a lower resolution, resampled to the size of its volume.

use rayon::prelude::*;

use super::DecodedFrame;
use super::mirror::trilinear;
use crate::memory::{self, OutOfMemory};
use crate::volume::{Extent, Level};

/// A frame of a lower resolution, sampled at every voxel centre of its volume (`extent` voxels) with the filter
/// *linear*. Its voxels have a shift ([`crate::codec::Decoder::coarse_shift`]). Voxel errors of a resolution compare the
/// volume with this.
///
/// # Errors
/// When there is no memory for it.
pub fn upsampled(
    frame: &DecodedFrame,
    extent: Extent,
    (resolution, shift): (u8, f32),
) -> Result<Vec<f32>, OutOfMemory> {
    let channels = frame.layout().channels as usize;
    let coarse = frame.layout().extent;
    let samples = extent.voxels() * channels as u64;
    let mut out: Vec<f32> = memory::zeroed(samples, || format!("a frame brought to {extent} voxels"))?;
    let scale = Level::scale(resolution) as f32;
    // Per axis and voxel: the two coarse voxels around its centre, clamped at the border, and the position between
    // them.
    let [x, y, z] = [0, 1, 2].map(|a| {
        let last = i64::from(coarse.to_array()[a]) - 1;
        let around = |i: u32| {
            let at = (i as f32 + 0.5) / scale - 0.5 + shift;
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
