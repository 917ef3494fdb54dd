//! A row of blocks along x, as vectors.

use crate::codec::{Block, EncodeError};
use crate::volume::{BrickSource, Extent, FrameIndex, Region};

/// The voxels of all blocks of one row.
#[derive(Debug)]
pub struct BlockRow {
    values: Vec<f32>,
    /// Size of the row in voxels: the volume's width, and the height and depth of the blocks after the border cuts
    /// them.
    size: [usize; 3],
    block: [usize; 3],
    channels: usize,
}

impl BlockRow {
    /// Reads the row `by`, `bz` of the block grid.
    ///
    /// # Errors
    /// If the source fails.
    pub fn read(
        source: &dyn BrickSource,
        block: Block,
        frame: FrameIndex,
        by: u32,
        bz: u32,
    ) -> Result<Self, EncodeError> {
        let layout = source.layout();
        let first = block.region([0, by, bz], layout.extent);
        let [_, height, depth] = first.extent.to_array();
        let width = layout.extent.x();
        let whole = Extent::new(width, height, depth).unwrap_or(Extent::ONE);
        let channels = layout.channels as usize;
        let mut values = vec![0.0; whole.voxels() as usize * channels];
        source.read(frame, Region { origin: first.origin, extent: whole }, &mut values)?;
        let to_usize = |size: [u32; 3]| size.map(|s| s as usize);
        Ok(Self { values, size: to_usize(whole.to_array()), block: to_usize(block.0.to_array()), channels })
    }

    /// All values of the row's voxels.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Size of block `bx` in voxels. At the volume's border it is less than a whole block.
    ///
    /// # Panics
    /// If there is no such block.
    #[must_use]
    pub fn cut(&self, bx: u32) -> [usize; 3] {
        let left = self.size[0] - bx as usize * self.block[0];
        [left.min(self.block[0]), self.size[1], self.size[2]]
    }

    /// Appends block `bx` as a vector: voxels x fastest, channels interleaved. Beyond the volume's border the last
    /// voxel is repeated.
    ///
    /// # Panics
    /// If there is no such block.
    pub fn append(&self, bx: u32, vector: &mut Vec<f32>) {
        let (cut, first) = (self.cut(bx), bx as usize * self.block[0]);
        for z in 0..self.block[2] {
            for y in 0..self.block[1] {
                let line = (z.min(cut[2] - 1) * self.size[1] + y.min(cut[1] - 1)) * self.size[0] + first;
                let inside = line * self.channels..(line + cut[0]) * self.channels;
                let last = inside.end - self.channels..inside.end;
                vector.extend_from_slice(&self.values[inside]);
                for _ in cut[0]..self.block[0] {
                    vector.extend_from_slice(&self.values[last.clone()]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{DenseVolume, SampleType, Samples, VolumeLayout};

    fn volume(size: [u32; 3], channels: u32) -> DenseVolume {
        let extent = Extent::try_from(size).unwrap();
        let layout = VolumeLayout { channels, ..VolumeLayout::scalar(extent, SampleType::U8) };
        let samples = Samples::U8((0..layout.samples() as u8).collect());
        DenseVolume::new(layout, samples).unwrap()
    }

    fn vector(row: &BlockRow, bx: u32) -> Vec<f32> {
        let mut vector = Vec::new();
        row.append(bx, &mut vector);
        vector
    }

    #[test]
    fn a_whole_block_is_its_voxels_in_order() {
        let block: Block = "2x2x1".parse().unwrap();
        let row = BlockRow::read(&volume([4, 2, 2], 1), block, FrameIndex::FIRST, 0, 1).unwrap();
        assert_eq!(vector(&row, 1), [10.0, 11.0, 14.0, 15.0]);
        assert_eq!(row.cut(1), [2, 2, 1]);
    }

    #[test]
    fn a_cut_block_repeats_its_last_voxels() {
        let block: Block = "2x2x2".parse().unwrap();
        let row = BlockRow::read(&volume([3, 1, 2], 1), block, FrameIndex::FIRST, 0, 0).unwrap();
        assert_eq!(row.cut(1), [1, 1, 2]);
        assert_eq!(vector(&row, 1), [2.0, 2.0, 2.0, 2.0, 5.0, 5.0, 5.0, 5.0]);
    }

    #[test]
    fn colours_are_interleaved() {
        let block: Block = "2x1x1".parse().unwrap();
        let row = BlockRow::read(&volume([3, 1, 1], 3), block, FrameIndex::FIRST, 0, 0).unwrap();
        assert_eq!(vector(&row, 0), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(vector(&row, 1), [6.0, 7.0, 8.0, 6.0, 7.0, 8.0]);
    }
}
