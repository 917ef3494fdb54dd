//! Decodes one voxel from the two volumes. The twin of decode.wgsl, function for function, except that the kit derives
//! cells and rows here. This code defines the codec.

use cvr_core::kit::{BlockFrame, BlockGrid};
use cvr_core::volume::ValueRange;

use crate::geometry::Geometry;

/// One frame of a stream.
#[derive(Copy, Clone, Debug)]
pub struct Frame<'a> {
    /// The MinMax volume: `geometry.minmax_words()` words.
    pub minmax: &'a [u32],
    /// The Index volume: `geometry.index_words()` words.
    pub index: &'a [u32],
    /// Sizes.
    pub geometry: &'a Geometry,
}

/// Data that the voxels of a block share.
#[derive(Copy, Clone, Debug)]
pub struct Head {
    /// Minimum and maximum of each channel.
    ends: [[f32; 2]; 3],
    /// First voxel.
    origin: [u32; 3],
}

impl Frame<'_> {
    /// An endpoint of an integer type, from the code in its low bits.
    #[inline]
    fn integer(&self, code: u32) -> f32 {
        let shift = 32 - self.geometry.endpoint.bits;
        let high = code << shift;
        if self.geometry.endpoint.signed {
            return (high as i32 >> shift) as f32;
        }
        (high >> shift) as f32
    }

    /// Minimum and maximum of entry `entry` (block in memory order × channels + channel).
    ///
    /// # Panics
    /// When there is no such entry.
    #[must_use]
    #[inline]
    pub fn endpoints(&self, entry: usize) -> [f32; 2] {
        if self.geometry.endpoint.bits == 32 {
            return [f32::from_bits(self.minmax[2 * entry]), f32::from_bits(self.minmax[2 * entry + 1])];
        }
        if self.geometry.endpoint.bits == 16 {
            let word = self.minmax[entry];
            return [self.integer(word), self.integer(word >> 16)];
        }
        let word = self.minmax[entry >> 1] >> ((entry & 1) * 16);
        [self.integer(word), self.integer(word >> 8)]
    }

    /// Equation 2 of the paper. It is the codec's only floating-point expression.
    #[must_use]
    #[inline]
    pub fn value(&self, ends: [f32; 2], index: u32) -> f32 {
        value(ends, index, self.geometry.reciprocal)
    }

    /// First entry of a block.
    #[must_use]
    #[inline]
    pub fn entry(&self, block: [u32; 3]) -> usize {
        self.geometry.grid.number(block) * self.geometry.channels as usize
    }

    /// First word of a row of indices.
    #[must_use]
    #[inline]
    pub fn row(&self, y: u32, z: u32) -> usize {
        (z as usize * self.geometry.grid.volume().y() as usize + y as usize)
            * self.geometry.row_words as usize
    }

    /// The range of a block over all channels.
    ///
    /// # Panics
    /// When there is no such block.
    #[must_use]
    pub fn range(&self, block: [u32; 3]) -> ValueRange {
        let ends = self.head(block).ends.into_iter().take(BlockFrame::channels(self));
        let ranges = ends.map(|[min, max]| ValueRange { min, max });
        ranges.reduce(ValueRange::union).unwrap_or(ValueRange { min: 0.0, max: 0.0 })
    }
}

impl BlockFrame for Frame<'_> {
    type Head = Head;

    fn grid(&self) -> &BlockGrid {
        &self.geometry.grid
    }

    fn channels(&self) -> usize {
        self.geometry.channels as usize
    }

    #[inline]
    fn head(&self, block: [u32; 3]) -> Head {
        let (entry, size) = (self.entry(block), self.geometry.grid.block().0.to_array());
        let mut ends = [[0.0; 2]; 3];
        for (c, ends) in ends.iter_mut().enumerate().take(BlockFrame::channels(self)) {
            *ends = self.endpoints(entry + c);
        }
        Head { ends, origin: [0, 1, 2].map(|a| block[a] * size[a]) }
    }

    #[inline]
    fn voxel(&self, head: Head, inside: [u32; 3], c: usize) -> f32 {
        let (g, p) = (self.geometry, [0, 1, 2].map(|a| head.origin[a] + inside[a]));
        let bit = (p[0] as usize * g.channels as usize + c) * g.index_bits as usize;
        let word = self.index[self.row(p[1], p[2]) + (bit >> 5)];
        self.value(head.ends[c], (word >> (bit & 31)) & g.levels())
    }
}

/// Equation 2, with the division as a product: `min + (max − min)·index/(2^i − 1)`, limited to the maximum, which
/// rounding might exceed.
#[inline]
pub(crate) fn value(ends: [f32; 2], index: u32, reciprocal: f32) -> f32 {
    (ends[0] + (ends[1] - ends[0]) * (index as f32 * reciprocal)).min(ends[1])
}
