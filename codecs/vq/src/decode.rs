//! Decodes one voxel from indices and codewords. The twin of decode.wgsl, function for function, except that the kit
//! derives cells and rows here. This code defines the codec.

use cvr_codebook::pack::unpack;
use cvr_core::kit::{BlockFrame, BlockGrid};

use crate::geometry::Geometry;

/// One frame of a stream.
#[derive(Copy, Clone, Debug)]
pub struct Frame<'a> {
    /// Indices: `geometry.index_words()` words.
    pub index: &'a [u32],
    /// The codewords that serve this frame: `geometry.table_words()` words.
    pub codebook: &'a [u32],
    /// Sizes.
    pub geometry: &'a Geometry,
}

impl Frame<'_> {
    /// Value of a code, in data units. It is the codec's only floating-point expression.
    #[must_use]
    #[inline]
    pub fn value(&self, code: u32) -> f32 {
        self.geometry.quantiser.value(code)
    }

    /// Code `i` of the codebook. The values of a codeword are adjacent; codewords follow one another.
    ///
    /// # Panics
    /// When there is no such code.
    #[must_use]
    #[inline]
    pub fn code(&self, i: usize) -> u32 {
        let (bits, lanes_log2) = (self.geometry.quantiser.bits(), self.geometry.lanes_log2());
        let lane = i as u32 & ((1 << lanes_log2) - 1);
        (self.codebook[i >> lanes_log2] >> (lane * bits)) & ((1 << bits) - 1)
    }

    /// Index of a block. 32 indices fill `index_bits` words. An index may span two words.
    ///
    /// # Panics
    /// When there is no such block.
    #[must_use]
    #[inline]
    pub fn index_of(&self, block: [u32; 3]) -> u32 {
        unpack(self.index, self.geometry.index_bits, self.geometry.grid.number(block))
    }

    /// First code of a block's codeword.
    ///
    /// # Panics
    /// When there is no such block.
    #[must_use]
    #[inline]
    pub fn codeword(&self, block: [u32; 3]) -> usize {
        self.index_of(block) as usize * self.geometry.dimension() as usize
    }

    /// First code of a voxel, relative to its codeword. `inside` is the position in the block.
    #[must_use]
    #[inline]
    pub fn place(&self, inside: [u32; 3]) -> usize {
        self.geometry.grid.place(inside) * self.geometry.channels as usize
    }
}

/// A head is the first code of a block's codeword.
impl BlockFrame for Frame<'_> {
    type Head = usize;

    fn grid(&self) -> &BlockGrid {
        &self.geometry.grid
    }

    fn channels(&self) -> usize {
        self.geometry.channels as usize
    }

    #[inline]
    fn head(&self, block: [u32; 3]) -> usize {
        self.codeword(block)
    }

    #[inline]
    fn voxel(&self, codeword: usize, inside: [u32; 3], c: usize) -> f32 {
        self.value(self.code(codeword + self.place(inside) + c))
    }
}
