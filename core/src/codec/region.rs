//! Decoding a box of voxels by a codec of which any voxel decodes on its own.

use crate::render::Cell;
use crate::volume::Region;

/// Decodes a box by whichever of three ways fits it: `fetch` for a voxel, `fetch_cell` for 2×2×2 voxels (corner `i` takes
/// x from bit 0, y from bit 1, z from bit 2), which is how the CPU mirror draws at the site *inline*, and else `row`,
/// which fills voxels from a start on along x. The body of [`super::Decoder::decode_brick`] of such a codec, once
/// [`super::check_key`] has seen the key.
///
/// # Panics
/// When `out` has not exactly region voxels × channels elements.
pub fn decode_region(
    region: Region,
    channels: u32,
    out: &mut [f32],
    fetch: impl FnOnce([u32; 3]) -> [f32; 4],
    fetch_cell: impl FnOnce([u32; 3], [u32; 3]) -> Cell,
    mut row: impl FnMut([u32; 3], &mut [f32]),
) {
    let channels = channels as usize;
    let Region { origin, extent } = region;
    assert_eq!(out.len() as u64, extent.voxels() * channels as u64, "output of the wrong size");
    match extent.to_array() {
        [1, 1, 1] => out.copy_from_slice(&fetch(origin)[..channels]),
        [2, 2, 2] => {
            let corners = fetch_cell(origin, origin.map(|o| o + 1));
            for (out, corner) in out.chunks_exact_mut(channels).zip(corners) {
                out.copy_from_slice(&corner[..channels]);
            }
        }
        [x, ..] => {
            let rows = region.rows().zip(out.chunks_exact_mut(x as usize * channels));
            rows.for_each(|(start, out)| row(start, out));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Extent;

    /// Every way gives the same voxels, each in its place.
    #[test]
    fn a_box_of_any_shape_is_its_voxels() {
        let whole = Extent::new(5, 4, 3).unwrap();
        let voxel = |p: [u32; 3]| {
            let at = whole.index(p) as f32;
            [at, at + 0.25, at + 0.5, 0.0]
        };
        let cell = |p: [u32; 3], q: [u32; 3]| {
            std::array::from_fn(|i| voxel([0, 1, 2].map(|a| if i >> a & 1 == 0 { p[a] } else { q[a] })))
        };
        let row = |start: [u32; 3], out: &mut [f32]| {
            for (x, out) in out.chunks_exact_mut(3).enumerate() {
                out.copy_from_slice(&voxel([start[0] + x as u32, start[1], start[2]])[..3]);
            }
        };
        for (origin, size) in [([1, 2, 1], [1, 1, 1]), ([3, 1, 0], [2, 2, 2]), ([0, 1, 1], [5, 3, 2])] {
            let region = Region { origin, extent: Extent::try_from(size).unwrap() };
            let mut out = vec![0.0; region.extent.voxels() as usize * 3];
            decode_region(region, 3, &mut out, voxel, cell, row);
            for (i, values) in out.chunks_exact(3).enumerate() {
                let inside = region.extent.position(i);
                let p = [0, 1, 2].map(|a| origin[a] + inside[a]);
                assert_eq!(values, &voxel(p)[..3], "{p:?} of {region:?}");
            }
        }
    }
}
