//! Decodes one voxel from a mean, two indices and two codewords. The twin of decode.wgsl, function for function, except
//! that the kit derives cells and rows here. This code defines the codec.

use cvr_codebook::pack::unpack;
use cvr_core::kit::{BlockFrame, BlockGrid};

use crate::geometry::{Geometry, Plane};

/// One frame of a stream at a level.
#[derive(Copy, Clone, Debug)]
pub struct Frame<'a> {
    /// Means and indices: `geometry.index_words()` words.
    pub index: &'a [u32],
    /// The codewords that serve this frame: `geometry.table_words()` words.
    pub codebook: &'a [u32],
    /// Sizes.
    pub geometry: &'a Geometry,
    /// Number of stages: the mean, from 2 on the coarse differences, from 3 on the detail.
    pub stages: u8,
}

/// Data that the voxels of a block share: its number, and the first codes of its two codewords.
pub type Head = [usize; 3];

impl Frame<'_> {
    /// Value of a sum of levels, in data units. It is the codec's only floating-point expression.
    #[must_use]
    #[inline]
    pub fn value(&self, level: i32) -> f32 {
        self.geometry.levels.value(level.clamp(0, self.geometry.top as i32) as u32)
    }

    /// Number `i` of a plane. 32 numbers fill as many words as a number has bits. A number may span two words.
    ///
    /// # Panics
    /// When there is no such number.
    #[must_use]
    #[inline]
    pub fn number(&self, plane: Plane, i: usize) -> u32 {
        unpack(&self.index[plane.first as usize..], plane.bits, i)
    }

    /// Code `i` of the codewords whose first word is `first`.
    ///
    /// # Panics
    /// When there is no such code.
    #[must_use]
    #[inline]
    pub fn code(&self, first: u64, i: usize) -> i32 {
        let (bits, lanes_log2) = (self.geometry.codeword_bits, self.geometry.lanes_log2());
        let lane = i as u32 & ((1 << lanes_log2) - 1);
        ((self.codebook[first as usize + (i >> lanes_log2)] >> (lane * bits)) & ((1 << bits) - 1)) as i32
    }

    /// The head of a block.
    ///
    /// # Panics
    /// When there is no such block.
    #[must_use]
    #[inline]
    pub fn head_of(&self, block: [u32; 3]) -> Head {
        let g = self.geometry;
        let b = g.grid.number(block);
        let mut head = [b, 0, 0];
        if self.stages > 1 {
            head[1] = self.number(g.coarse.plane, b) as usize * g.coarse.dimension as usize;
        }
        if self.stages > 2 {
            head[2] = self.number(g.detail.plane, b) as usize * g.detail.dimension as usize;
        }
        head
    }

    /// Levels of the mean of channel `c` of block number `b`.
    ///
    /// # Panics
    /// When there is no such block.
    #[must_use]
    #[inline]
    pub fn mean(&self, b: usize, c: usize) -> i32 {
        let g = self.geometry;
        (self.number(g.means, b * g.channels as usize + c) * g.mean_step) as i32
    }

    /// Levels that a code of a coarse codeword adds.
    #[must_use]
    #[inline]
    pub fn coarse(&self, code: i32) -> i32 {
        (code - self.geometry.coarse.zero as i32) * self.geometry.coarse.step as i32
    }

    /// Levels that a code of a detail codeword adds.
    #[must_use]
    #[inline]
    pub fn detail(&self, code: i32) -> i32 {
        (code - self.geometry.detail.zero as i32) * self.geometry.detail.step as i32
    }

    /// First code of a voxel's sub-block, relative to the coarse codeword. `inside` is the voxel's position in the
    /// block.
    #[must_use]
    #[inline]
    pub fn sub_block(&self, inside: [u32; 3]) -> usize {
        let sub = ((inside[2] & 2) << 1) | (inside[1] & 2) | (inside[0] >> 1);
        (sub * self.geometry.channels) as usize
    }

    /// First code of a voxel, relative to the detail codeword.
    #[must_use]
    #[inline]
    pub fn place(&self, inside: [u32; 3]) -> usize {
        self.geometry.grid.place(inside) * self.geometry.channels as usize
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
        self.head_of(block)
    }

    #[inline]
    fn voxel(&self, head: Head, inside: [u32; 3], c: usize) -> f32 {
        let mut level = self.mean(head[0], c);
        if self.stages > 1 {
            level += self.coarse(self.code(self.geometry.coarse.first, head[1] + self.sub_block(inside) + c));
        }
        if self.stages > 2 {
            level += self.detail(self.code(self.geometry.detail.first, head[2] + self.place(inside) + c));
        }
        self.value(level)
    }
}
