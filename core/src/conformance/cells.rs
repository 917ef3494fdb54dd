//! Compares grid cells with their voxels, for codecs that decode the two in different ways.

use crate::render::Cell;
use crate::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};

/// Compares every grid cell of a volume with eight fetches, also the cells cut at its faces.
///
/// # Errors
/// A sentence that names the first cell and corner that differ.
pub fn cells_are_eight_fetches(
    extent: Extent,
    fetch: impl Fn([u32; 3]) -> [f32; 4],
    fetch_cell: impl Fn([u32; 3], [u32; 3]) -> Cell,
) -> Result<(), String> {
    let size = extent.to_array();
    for p in (0..extent.voxels() as usize).map(|i| extent.position(i)) {
        for far in 0..8_u32 {
            let q = [0, 1, 2].map(|a| (p[a] + (far >> a & 1)).min(size[a] - 1));
            for (i, corner) in fetch_cell(p, q).into_iter().enumerate() {
                let at = [0, 1, 2].map(|a: usize| if i >> a & 1 == 1 { q[a] } else { p[a] });
                let voxel = fetch(at);
                if corner != voxel {
                    return Err(format!("corner {i} of {p:?} to {q:?} is {corner:?}, the voxel {voxel:?}"));
                }
            }
        }
    }
    Ok(())
}

/// Noise of 16 bits with one or three channels, equal on every platform.
///
/// # Panics
/// When an axis is 0.
#[must_use]
pub fn noise(size: [u32; 3], channels: u32, seed: u32) -> FiniteVolume {
    #[allow(clippy::unwrap_used, reason = "the volume is made of what its layout says")]
    let make = || {
        let extent = Extent::try_from(size).unwrap();
        let layout = VolumeLayout { channels, ..VolumeLayout::scalar(extent, SampleType::U16) };
        let value = |i: u64| ((i as u32 ^ seed).wrapping_mul(0x9e37_79b9) >> 16) as u16;
        let samples = Samples::U16((0..layout.samples()).map(value).collect());
        FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
    };
    make()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_wrong_corner_is_seen() {
        let extent = Extent::new(3, 2, 1).unwrap();
        let fetch = |p: [u32; 3]| [extent.index(p) as f32, 0.0, 0.0, 0.0];
        let cell = |p: [u32; 3], q: [u32; 3]| -> Cell {
            std::array::from_fn(|i| {
                fetch([0, 1, 2].map(|a: usize| if i >> a & 1 == 1 { q[a] } else { p[a] }))
            })
        };
        cells_are_eight_fetches(extent, fetch, cell).unwrap();
        let wrong = |p, q| {
            let mut cell = cell(p, q);
            if p == [1, 0, 0] {
                cell.swap(0, 3);
            }
            cell
        };
        assert!(cells_are_eight_fetches(extent, fetch, wrong).is_err());
    }
}
