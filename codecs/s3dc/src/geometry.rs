//! Positions of blocks, endpoints and indices in the two tensors.

use cvr_core::codec::Block;
use cvr_core::kit::BlockGrid;
use cvr_core::volume::VolumeLayout;
use serde::{Deserialize, Serialize};

use crate::endpoint::Endpoint;

/// The decode parameters in the container.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Size of a block in voxels.
    pub block: Block,
    /// Bits per index: 1, 2, 4 or 8.
    pub index_bits: u32,
}

/// Sizes that follow from layout and parameters.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Blocks over the volume.
    pub grid: BlockGrid,
    /// Values per voxel: 1 or 3.
    pub channels: u32,
    /// Bits per index: 1, 2, 4 or 8.
    pub index_bits: u32,
    /// Words in one row of indices.
    pub row_words: u64,
    /// How an endpoint is stored.
    pub endpoint: Endpoint,
    /// `1 / (2^index_bits − 1)`: scales the largest index to 1.
    pub reciprocal: f32,
}

impl Geometry {
    /// The geometry. `None` if the parameters are out of range (block 1..=128, bits 1, 2, 4, 8).
    #[must_use]
    pub fn new(layout: &VolumeLayout, block: Block, index_bits: u32) -> Option<Self> {
        if !matches!(index_bits, 1 | 2 | 4 | 8) || block.0.to_array().iter().any(|a| *a > 128) {
            return None;
        }
        let row_bits = u64::from(layout.extent.x()) * u64::from(layout.channels) * u64::from(index_bits);
        Some(Self {
            grid: BlockGrid::new(block, layout.extent),
            channels: layout.channels,
            index_bits,
            row_words: row_bits.div_ceil(32),
            endpoint: Endpoint::new(layout.sample),
            reciprocal: 1.0 / ((1_u32 << index_bits) - 1) as f32,
        })
    }

    /// Largest index, `2^index_bits − 1`.
    #[must_use]
    pub const fn levels(&self) -> u32 {
        (1 << self.index_bits) - 1
    }

    /// Words of the MinMax volume, one frame.
    #[must_use]
    pub const fn minmax_words(&self) -> u64 {
        (self.grid.blocks().voxels() * self.channels as u64 * self.endpoint.entry_bits() as u64).div_ceil(32)
    }

    /// Words of the Index volume, one frame.
    #[must_use]
    pub const fn index_words(&self) -> u64 {
        self.row_words * self.grid.volume().y() as u64 * self.grid.volume().z() as u64
    }

    /// Shape of the tensor `minmax`.
    #[must_use]
    pub fn minmax_shape(&self, frames: u32) -> [u64; 2] {
        [u64::from(frames), self.minmax_words()]
    }

    /// Shape of the tensor `index`.
    #[must_use]
    pub fn index_shape(&self, frames: u32) -> [u64; 4] {
        [u64::from(frames), self.grid.volume().z().into(), self.grid.volume().y().into(), self.row_words]
    }

    /// Whether a shader can address one frame with 32-bit numbers of words and of bits in a row.
    #[must_use]
    pub const fn fits_a_shader(&self) -> bool {
        const LARGEST: u64 = u32::MAX as u64;
        self.minmax_words() <= LARGEST && self.index_words() <= LARGEST && self.row_words <= LARGEST / 32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::volume::{Extent, SampleType};

    #[test]
    fn the_largest_index_reaches_the_maximum() {
        let layout = VolumeLayout::scalar(Extent::ONE, SampleType::U8);
        for bits in [1, 2, 4, 8] {
            let geometry = Geometry::new(&layout, Block(Extent::ONE), bits).unwrap();
            assert_eq!(geometry.levels() as f32 * geometry.reciprocal, 1.0, "{bits} bits");
        }
    }

    #[test]
    fn rows_and_frames_are_whole_words() {
        let layout = VolumeLayout::scalar(Extent::new(13, 17, 23).unwrap(), SampleType::U8);
        let geometry = Geometry::new(&layout, "4".parse().unwrap(), 4).unwrap();
        assert_eq!(geometry.row_words, 2);
        assert_eq!(geometry.index_words(), 2 * 17 * 23);
        assert_eq!(geometry.minmax_words(), (4 * 5 * 6_u64).div_ceil(2));
    }
}
