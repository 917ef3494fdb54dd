//! Where blocks lie in the tensor.

use cvr_core::volume::{Extent, VolumeLayout};

use crate::block::EDGE;

/// Sizes that follow from the layout.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Geometry {
    /// Voxels.
    pub extent: Extent,
    /// Blocks along x and along y, those at the border whole.
    pub grid: [u32; 2],
    /// Values per voxel: 1 or 3.
    pub channels: u32,
}

impl Geometry {
    /// The geometry of a volume.
    #[must_use]
    pub const fn new(layout: &VolumeLayout) -> Self {
        let VolumeLayout { extent, channels, .. } = layout;
        Self {
            extent: *extent,
            grid: [extent.x().div_ceil(EDGE), extent.y().div_ceil(EDGE)],
            channels: *channels,
        }
    }

    /// Words of the blocks of one channel of a slice.
    #[must_use]
    pub const fn plane_words(&self) -> u64 {
        2 * self.grid[0] as u64 * self.grid[1] as u64
    }

    /// Words of one frame.
    #[must_use]
    pub const fn frame_words(&self) -> u64 {
        self.plane_words() * self.channels as u64 * self.extent.z() as u64
    }

    /// Shape of the tensor `blocks`.
    #[must_use]
    pub fn shape(&self, frames: u32) -> [u64; 5] {
        let [columns, rows] = self.grid.map(u64::from);
        [frames.into(), self.extent.z().into(), self.channels.into(), rows, 2 * columns]
    }

    /// First word of the block of channel `c` that voxel `p` lies in.
    #[must_use]
    #[inline]
    pub const fn first_word(&self, p: [u32; 3], c: u32) -> usize {
        let plane = p[2] as usize * self.channels as usize + c as usize;
        let row = plane * self.grid[1] as usize + (p[1] / EDGE) as usize;
        2 * (row * self.grid[0] as usize + (p[0] / EDGE) as usize)
    }

    /// Whether a shader, which counts words in 32 bits, can address one frame.
    #[must_use]
    pub const fn fits_a_shader(&self) -> bool {
        self.frame_words() <= u32::MAX as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::volume::SampleType;

    #[test]
    fn every_block_has_two_words_of_its_own() {
        let extent = Extent::new(13, 17, 3).unwrap();
        let layout = VolumeLayout { channels: 3, ..VolumeLayout::scalar(extent, SampleType::U8) };
        let geometry = Geometry::new(&layout);
        assert_eq!((geometry.grid, geometry.frame_words()), ([4, 5], 2 * 4 * 5 * 3 * 3));
        assert_eq!(geometry.shape(2).iter().product::<u64>(), 2 * geometry.frame_words());
        let mut words = Vec::new();
        for z in 0..3 {
            for c in 0..3 {
                for y in (0..17).step_by(4) {
                    words.extend((0..13).step_by(4).map(|x| geometry.first_word([x + x % 2, y, z], c)));
                }
            }
        }
        assert!(words.into_iter().eq((0..180).map(|block| 2 * block)));
    }
}
