//! One voxel out of indices and codewords: the twin of decode.wgsl, function for function, but that cells and rows are the
//! kit's here. This one defines the codec.

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
    /// Value of a code, in data units: the only float expression of the codec.
    #[must_use]
    #[inline]
    pub fn value(&self, code: u32) -> f32 {
        self.geometry.quantiser.value(code)
    }

    /// Code `i` of the codebook: the values of a codeword side by side, codeword after codeword.
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

    /// Index of a block. 32 of them fill `index_bits` words; one may lie in two.
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

    /// First code of a voxel, counted from the codeword's: `inside` is its place in the block.
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
