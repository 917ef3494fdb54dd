//! A frame whose voxels come block by block.

use super::voxels::corner;
use super::{BlockGrid, FetchVoxels, Voxel};
use crate::render::Cell;

/// A frame whose voxels share a *head* per block: data that is found once per block, such as endpoints or the first
/// code of a codeword. Voxels, cells and rows are derived from it.
pub trait BlockFrame {
    /// The data that all voxels and channels of a block share.
    type Head: Copy;

    /// The grid of blocks.
    fn grid(&self) -> &BlockGrid;

    /// Values per voxel: 1 or 3.
    fn channels(&self) -> usize;

    /// The head of a block.
    ///
    /// # Panics
    /// When there is no such block.
    fn head(&self, block: [u32; 3]) -> Self::Head;

    /// Channel `c` of the voxel at `inside` of a block.
    ///
    /// # Panics
    /// When there is no such voxel.
    fn voxel(&self, head: Self::Head, inside: [u32; 3], c: usize) -> f32;
}

/// Each channel of a voxel.
#[inline]
fn all_channels<F: BlockFrame>(frame: &F, head: F::Head, inside: [u32; 3]) -> Voxel {
    let mut out = [0.0; 4];
    for (c, out) in out.iter_mut().enumerate().take(BlockFrame::channels(frame)) {
        *out = frame.voxel(head, inside, c);
    }
    out
}

impl<F: BlockFrame> FetchVoxels for F {
    fn channels(&self) -> usize {
        BlockFrame::channels(self)
    }

    #[inline]
    fn fetch(&self, p: [u32; 3]) -> Voxel {
        let (block, inside) = self.grid().split(p);
        all_channels(self, self.head(block), inside)
    }

    /// Finds the head of each of the one to eight blocks once.
    #[inline]
    fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> Cell {
        let ((from, a), (to, b)) = (self.grid().split(p), self.grid().split(q));
        // Bits of the axes along which the cell reaches into another block.
        let crossed: usize = (0..3).map(|axis| usize::from(from[axis] != to[axis]) << axis).sum();
        let mut heads: [Option<F::Head>; 8] = [None; 8];
        std::array::from_fn(|i| {
            let block = i & crossed;
            let head = *heads[block].get_or_insert_with(|| self.head(corner(from, to, block)));
            all_channels(self, head, corner(a, b, i))
        })
    }

    /// Finds the head of each block once.
    fn fetch_row(&self, start: [u32; 3], out: &mut [f32]) {
        let (width, channels) = (self.grid().block().0.x(), BlockFrame::channels(self));
        let (mut p, mut rest) = (start, out);
        while !rest.is_empty() {
            let (block, inside) = self.grid().split(p);
            let run = width - inside[0];
            let (part, later) = rest.split_at_mut((run as usize * channels).min(rest.len()));
            let head = self.head(block);
            for (x, out) in (inside[0]..).zip(part.chunks_exact_mut(channels)) {
                for (c, out) in out.iter_mut().enumerate() {
                    *out = self.voxel(head, [x, inside[1], inside[2]], c);
                }
            }
            p[0] += run;
            rest = later;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell as Count;

    use super::*;
    use crate::kit::voxels::decode_region;
    use crate::volume::{Extent, Region};

    /// Each voxel is its block's number and its place; counts heads.
    struct Numbered {
        grid: BlockGrid,
        heads: Count<u32>,
    }

    impl BlockFrame for Numbered {
        type Head = usize;

        fn grid(&self) -> &BlockGrid {
            &self.grid
        }

        fn channels(&self) -> usize {
            3
        }

        fn head(&self, block: [u32; 3]) -> usize {
            self.heads.set(self.heads.get() + 1);
            self.grid.number(block)
        }

        fn voxel(&self, head: usize, inside: [u32; 3], c: usize) -> f32 {
            (head * 1000 + self.grid.place(inside) * 10 + c) as f32
        }
    }

    #[test]
    fn cells_and_rows_are_their_voxels_and_find_each_head_once() {
        let grid = BlockGrid::new("3x2x2".parse().unwrap(), Extent::new(8, 5, 4).unwrap());
        let frame = Numbered { grid, heads: Count::new(0) };
        for p in Region::whole(grid.volume()).positions() {
            let rest = grid.volume().to_array();
            let size = [0, 1, 2].map(|a| (rest[a] - p[a]).min(2));
            for size in [size, [rest[0] - p[0], 1, 1]] {
                let region = Region { origin: p, extent: Extent::try_from(size).unwrap() };
                let mut out = vec![0.0; region.extent.voxels() as usize * 3];
                frame.heads.set(0);
                decode_region(&frame, region, &mut out);
                if size == [2, 2, 2] {
                    assert_eq!(u64::from(frame.heads.get()), grid.touched(region).extent.voxels(), "{p:?}");
                }
                for (p, values) in region.positions().zip(out.chunks_exact(3)) {
                    assert_eq!(values, &frame.fetch(p)[..3], "{p:?} of {region:?}");
                }
            }
            let q = [0, 1, 2].map(|a| p[a] + size[a] - 1);
            let cell = frame.fetch_cell(p, q);
            assert_eq!(cell, std::array::from_fn(|i| frame.fetch(corner(p, q, i))));
        }
    }
}
