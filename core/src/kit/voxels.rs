//! Decoding a box of voxels. Each voxel decodes on its own.

use super::BlockGrid;
use crate::render::Cell;
use crate::volume::Region;

/// A voxel: one value per channel. Unused channels are 0.
pub type Voxel = [f32; 4];

/// A frame whose voxels decode on their own. A cell, a row or a box may have a faster path with equal values.
pub trait FetchVoxels {
    /// Values per voxel: 1 or 3.
    fn channels(&self) -> usize;

    /// The voxel at `p`.
    ///
    /// # Panics
    /// If `p` lies outside.
    fn fetch(&self, p: [u32; 3]) -> Voxel;

    /// The corners of the grid cell from `p` to `q`. `q` is `p` or `p + 1` along each axis. Corner `i` takes x from bit
    /// 0, y from bit 1, z from bit 2 of `i`.
    ///
    /// # Panics
    /// If a corner lies outside.
    fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> Cell {
        std::array::from_fn(|i| self.fetch(corner(p, q, i)))
    }

    /// Voxels from `start` on along x, channels interleaved.
    ///
    /// # Panics
    /// If a voxel lies outside.
    fn fetch_row(&self, start: [u32; 3], out: &mut [f32]) {
        let channels = self.channels();
        for (x, out) in (start[0]..).zip(out.chunks_exact_mut(channels)) {
            out.copy_from_slice(&self.fetch([x, start[1], start[2]])[..channels]);
        }
    }

    /// All voxels of a box, row by row: x fastest, channels interleaved.
    ///
    /// # Panics
    /// If a voxel lies outside.
    fn fetch_box(&self, region: Region, out: &mut [f32]) {
        let row = region.extent.x() as usize * self.channels();
        region.rows().zip(out.chunks_exact_mut(row)).for_each(|(start, out)| self.fetch_row(start, out));
    }
}

/// Fills a box from whole blocks. Each block is decoded once: `values` returns all voxels of channel `c` of a block, x
/// fastest. Codecs whose blocks cost the same for one voxel as for all use it as their [`FetchVoxels::fetch_box`].
pub fn fill_from_blocks<V: AsRef<[f32]>>(
    grid: &BlockGrid,
    region: Region,
    channels: usize,
    out: &mut [f32],
    values: impl Fn([u32; 3], usize) -> V,
) {
    let end = |region: Region| [0, 1, 2].map(|a| region.origin[a] + region.extent.to_array()[a]);
    for block in grid.touched(region).positions() {
        let voxels = grid.voxels(block);
        let low = [0, 1, 2].map(|a| voxels.origin[a].max(region.origin[a]));
        let high = [0, 1, 2].map(|a| end(voxels)[a].min(end(region)[a]));
        for c in 0..channels {
            let values = values(block, c);
            for z in low[2]..high[2] {
                for y in low[1]..high[1] {
                    let [from, to] = [voxels.origin, region.origin]
                        .map(|origin| [low[0] - origin[0], y - origin[1], z - origin[2]]);
                    let row = &values.as_ref()[grid.place(from)..][..(high[0] - low[0]) as usize];
                    let to = out[region.extent.index(to) * channels + c..].iter_mut().step_by(channels);
                    to.zip(row).for_each(|(to, from)| *to = *from);
                }
            }
        }
    }
}

/// Corner `i` between `p` and `q`: x from bit 0, y from bit 1, z from bit 2.
#[inline]
pub(super) fn corner(p: [u32; 3], q: [u32; 3], i: usize) -> [u32; 3] {
    [0, 1, 2].map(|a| if i >> a & 1 == 0 { p[a] } else { q[a] })
}

/// Decodes a box into `out` (x fastest, channels interleaved). It uses the cheapest path: one voxel, a grid cell of
/// 2×2×2 voxels (the CPU mirror reads these at the site *inline*), or the whole box.
/// [`crate::codec::Decoder::decode_brick`] calls it after [`crate::codec::check_key`].
///
/// # Panics
/// If `out` does not have exactly region voxels × channels elements, or a voxel lies outside.
pub fn decode_region(frame: &impl FetchVoxels, region: Region, out: &mut [f32]) {
    let channels = frame.channels();
    let Region { origin, extent } = region;
    assert_eq!(out.len() as u64, extent.voxels() * channels as u64, "output of the wrong size");
    match extent.to_array() {
        [1, 1, 1] => out.copy_from_slice(&frame.fetch(origin)[..channels]),
        [2, 2, 2] => {
            let corners = frame.fetch_cell(origin, origin.map(|o| o + 1));
            for (out, corner) in out.chunks_exact_mut(channels).zip(corners) {
                out.copy_from_slice(&corner[..channels]);
            }
        }
        _ => frame.fetch_box(region, out),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Extent;

    /// Has no cell or row function of its own.
    struct Numbered(Extent);

    impl FetchVoxels for Numbered {
        fn channels(&self) -> usize {
            3
        }

        fn fetch(&self, p: [u32; 3]) -> Voxel {
            let at = self.0.index(p) as f32;
            [at, at + 0.25, at + 0.5, 0.0]
        }
    }

    #[test]
    fn a_box_is_filled_from_blocks() {
        let grid = BlockGrid::new("3x2x2".parse().unwrap(), Extent::new(8, 5, 4).unwrap());
        let voxel = |p: [u32; 3]| grid.volume().index(p) as f32;
        let values = |block: [u32; 3], c: usize| -> Vec<f32> {
            let first = grid.voxels(block).origin;
            let inside = Region::whole(grid.block().0).positions();
            inside
                .map(|i| [0, 1, 2].map(|a| (first[a] + i[a]).min(grid.volume().to_array()[a] - 1)))
                .map(|p| voxel(p) + 0.25 * c as f32)
                .collect()
        };
        for (origin, size) in [([0, 0, 0], [8, 5, 4]), ([2, 1, 1], [5, 3, 2]), ([7, 4, 3], [1, 1, 1])] {
            let region = Region { origin, extent: Extent::try_from(size).unwrap() };
            let mut out = vec![-1.0; region.extent.voxels() as usize * 3];
            fill_from_blocks(&grid, region, 3, &mut out, values);
            for (p, found) in region.positions().zip(out.chunks_exact(3)) {
                assert_eq!(found, [0.0, 0.25, 0.5].map(|c| voxel(p) + c), "{p:?} of {region:?}");
            }
        }
    }

    #[test]
    fn a_box_of_any_shape_is_its_voxels() {
        let frame = Numbered(Extent::new(5, 4, 3).unwrap());
        for (origin, size) in [([1, 2, 1], [1, 1, 1]), ([3, 1, 0], [2, 2, 2]), ([0, 1, 1], [5, 3, 2])] {
            let region = Region { origin, extent: Extent::try_from(size).unwrap() };
            let mut out = vec![0.0; region.extent.voxels() as usize * 3];
            decode_region(&frame, region, &mut out);
            for (p, values) in region.positions().zip(out.chunks_exact(3)) {
                assert_eq!(values, &frame.fetch(p)[..3], "{p:?} of {region:?}");
            }
        }
    }
}
