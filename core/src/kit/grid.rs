//! The grid of blocks over a volume.

use crate::codec::Block;
use crate::volume::{Extent, Region, ValueRange};

/// Blocks of one size over a volume, starting at its first voxel. The border cuts the last ones.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct BlockGrid {
    block: Block,
    volume: Extent,
    blocks: Extent,
}

impl BlockGrid {
    /// Blocks of this size over a volume.
    #[must_use]
    pub const fn new(block: Block, volume: Extent) -> Self {
        Self { block, volume, blocks: block.grid(volume) }
    }

    /// Size of a block in voxels.
    #[must_use]
    pub const fn block(&self) -> Block {
        self.block
    }

    /// Size of the volume in voxels.
    #[must_use]
    pub const fn volume(&self) -> Extent {
        self.volume
    }

    /// Blocks along each axis.
    #[must_use]
    pub const fn blocks(&self) -> Extent {
        self.blocks
    }

    /// The block of voxel `p`, and the position of `p` in that block.
    #[must_use]
    #[inline]
    pub fn split(&self, p: [u32; 3]) -> ([u32; 3], [u32; 3]) {
        let size = self.block.0.to_array();
        let block = [p[0] / size[0], p[1] / size[1], p[2] / size[2]];
        (block, [p[0] - block[0] * size[0], p[1] - block[1] * size[1], p[2] - block[2] * size[2]])
    }

    /// The number of a block: x fastest.
    #[must_use]
    #[inline]
    pub const fn number(&self, block: [u32; 3]) -> usize {
        self.blocks.index(block)
    }

    /// The number of a voxel in its block: x fastest.
    #[must_use]
    #[inline]
    pub const fn place(&self, inside: [u32; 3]) -> usize {
        self.block.0.index(inside)
    }

    /// The voxels of a block, cut at the volume's border.
    #[must_use]
    pub fn voxels(&self, block: [u32; 3]) -> Region {
        self.block.region(block, self.volume)
    }

    /// The blocks that a box of voxels inside the volume touches.
    #[must_use]
    pub fn touched(&self, region: Region) -> Region {
        let (size, extent) = (self.block.0.to_array(), region.extent.to_array());
        let from = [0, 1, 2].map(|a| region.origin[a] / size[a]);
        let count = [0, 1, 2].map(|a| (region.origin[a] + extent[a] - 1) / size[a] + 1 - from[a]);
        // There are no more blocks than voxels, and the voxels are an extent.
        Region { origin: from, extent: Extent::try_from(count).unwrap_or(Extent::ONE) }
    }

    /// The range of a box of voxels: the union of the ranges of the blocks that it touches.
    pub fn range(&self, region: Region, of_block: impl FnMut([u32; 3]) -> ValueRange) -> Option<ValueRange> {
        self.touched(region).positions().map(of_block).reduce(ValueRange::union)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> BlockGrid {
        BlockGrid::new("4x3x2".parse().unwrap(), Extent::new(13, 6, 5).unwrap())
    }

    #[test]
    fn a_voxel_lies_where_its_block_and_place_say() {
        let grid = grid();
        assert_eq!(grid.blocks().to_array(), [4, 2, 3]);
        for p in Region::whole(grid.volume()).positions() {
            let (block, inside) = grid.split(p);
            let voxels = grid.voxels(block);
            assert_eq!([0, 1, 2].map(|a| voxels.origin[a] + inside[a]), p);
            assert!((0..3).all(|a| inside[a] < voxels.extent.to_array()[a]));
        }
        assert_eq!((grid.number([1, 1, 2]), grid.place([1, 2, 1])), ((2 * 2 + 1) * 4 + 1, (3 + 2) * 4 + 1));
    }

    /// A box touches the blocks of its voxels, and no other.
    #[test]
    fn a_box_touches_the_blocks_of_its_voxels() {
        let grid = grid();
        for (origin, size) in [([0, 0, 0], [1, 1, 1]), ([3, 2, 1], [2, 2, 2]), ([4, 0, 2], [9, 6, 3])] {
            let region = Region { origin, extent: Extent::try_from(size).unwrap() };
            let mut blocks: Vec<_> = region.positions().map(|p| grid.number(grid.split(p).0)).collect();
            blocks.sort_unstable();
            blocks.dedup();
            assert_eq!(grid.touched(region).positions().map(|b| grid.number(b)).collect::<Vec<_>>(), blocks);
            let value = |block| ValueRange { min: grid.number(block) as f32, max: 100.0 };
            assert_eq!(grid.range(region, value).unwrap().min, blocks[0] as f32);
        }
    }
}
