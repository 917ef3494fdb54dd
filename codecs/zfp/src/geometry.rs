//! Positions of the bits of a block.

use cvr_core::codec::Block;
use cvr_core::kit::BlockGrid;
use cvr_core::volume::{Extent, ValueRange, VolumeLayout};
use serde::{Deserialize, Serialize};

/// Voxels along each axis of a block.
pub const EDGE: u32 = 4;
/// Samples of a block.
pub const SAMPLES: usize = 64;
/// Bits before a block's planes: a flag for a non-zero block, and the exponent.
pub const HEADER_BITS: u32 = 9;
/// Fewest bits per sample: a header.
pub const LOWEST_RATE: f64 = HEADER_BITS as f64 / SAMPLES as f64;
/// Most bits per sample: those of single precision.
pub const HIGHEST_RATE: f64 = 32.0;

/// Bits of a block at this rate in bits per sample, halves rounded up. At least a header.
#[must_use]
pub fn block_bits(rate: f64) -> u32 {
    let bits = (rate.clamp(LOWEST_RATE, HIGHEST_RATE) * SAMPLES as f64 + 0.5).floor();
    bits as u32
}

/// The decode parameters in the container.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Bits of a block: 9 to 2048.
    pub block_bits: u32,
    /// Blocks along x, y, z.
    pub grid: [u32; 3],
    /// Lowest and highest decoded value over all frames and channels.
    pub range: ValueRange,
}

/// Sizes that follow from layout and parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Blocks over the volume, edge blocks filled up.
    pub grid: BlockGrid,
    /// Values per voxel: 1 or 3. Each channel is coded separately.
    pub channels: u32,
    /// Bits of a block.
    pub block_bits: u32,
}

impl Geometry {
    /// The geometry of blocks of `block_bits` bits.
    #[must_use]
    pub fn of(layout: &VolumeLayout, block_bits: u32) -> Self {
        let grid = BlockGrid::new(block(), layout.extent);
        Self { grid, channels: layout.channels, block_bits }
    }

    /// The geometry. `None` if the parameters are out of range or contradict the layout.
    #[must_use]
    pub fn new(layout: &VolumeLayout, parameters: &Parameters) -> Option<Self> {
        let &Parameters { block_bits: bits, grid, range } = parameters;
        let geometry = Self::of(layout, bits);
        let fits = (HEADER_BITS..=block_bits(HIGHEST_RATE)).contains(&bits)
            && geometry.grid.blocks().to_array() == grid
            && range.min.is_finite()
            && range.max.is_finite()
            && range.min <= range.max;
        fits.then_some(geometry)
    }

    /// Words of one channel of one frame. As in zfp, a stream ends on a 64-bit word.
    #[must_use]
    pub const fn channel_words(&self) -> u64 {
        (self.grid.blocks().voxels() * self.block_bits as u64).div_ceil(64) * 2
    }

    /// Shape of the tensor.
    #[must_use]
    pub fn shape(&self, frames: u32) -> [u64; 3] {
        [u64::from(frames), u64::from(self.channels), self.channel_words()]
    }

    /// Whether a shader can address one frame with 32-bit numbers of blocks and words.
    #[must_use]
    pub const fn fits_a_shader(&self) -> bool {
        self.grid.blocks().voxels() <= u32::MAX as u64
            && self.channels as u64 * self.channel_words() <= u32::MAX as u64
    }
}

/// The block of 4³ voxels.
#[must_use]
pub fn block() -> Block {
    Block(Extent::cube(EDGE).unwrap_or(Extent::ONE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::volume::SampleType;

    #[test]
    fn a_rate_is_rounded_to_bits_of_a_block() {
        let rates = [0.0, 0.140_625, 0.15, 1.0, 1.1, 1.5, 3.007_812_5, 8.0, 32.0, 99.0];
        assert_eq!(rates.map(block_bits), [9, 9, 10, 64, 70, 96, 193, 512, 2048, 2048]);
    }

    #[test]
    fn blocks_are_packed_and_channels_are_whole_words_of_64_bits() {
        let layout = VolumeLayout::scalar(Extent::new(13, 17, 23).unwrap(), SampleType::U8);
        let geometry = Geometry::of(&layout, 70);
        assert_eq!(geometry.grid.blocks().to_array(), [4, 5, 6]);
        assert_eq!(geometry.channel_words(), (120 * 70_u64).div_ceil(64) * 2);
    }

    #[test]
    fn what_contradicts_the_layout_is_refused() {
        let layout = VolumeLayout::scalar(Extent::new(13, 17, 23).unwrap(), SampleType::U8);
        let right = Parameters { block_bits: 64, grid: [4, 5, 6], range: ValueRange { min: 0.0, max: 1.0 } };
        assert!(Geometry::new(&layout, &right).is_some());
        let wrong: [fn(&mut Parameters); 5] = [
            |p| p.grid[0] = 5,
            |p| p.block_bits = 8,
            |p| p.block_bits = 2049,
            |p| p.range.min = 2.0,
            |p| p.range.max = f32::INFINITY,
        ];
        for change in wrong {
            let mut parameters = right.clone();
            change(&mut parameters);
            assert_eq!(Geometry::new(&layout, &parameters), None);
        }
    }
}
