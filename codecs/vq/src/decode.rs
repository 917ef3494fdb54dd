//! One voxel out of indices and codewords: the twin of decode.wgsl, function for function. This one defines the codec.

use cvr_codebook::pack::unpack;

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

/// A voxel: one value per channel, 0 where there is no channel.
pub type Voxel = [f32; 4];

impl Frame<'_> {
    /// Value of a code, in data units: the only float expression of the codec.
    #[must_use]
    #[inline]
    pub fn value(&self, code: u32) -> f32 {
        self.geometry.quantiser.value(code)
    }

    /// Code `i` out of the word that holds it.
    #[inline]
    fn lane(&self, word: u32, i: usize) -> u32 {
        let bits = self.geometry.quantiser.bits();
        let lane = i as u32 & ((1 << self.geometry.lanes_log2()) - 1);
        (word >> (lane * bits)) & ((1 << bits) - 1)
    }

    /// Code `i` of the codebook: the values of a codeword side by side, codeword after codeword.
    ///
    /// # Panics
    /// When there is no such code.
    #[must_use]
    #[inline]
    pub fn code(&self, i: usize) -> u32 {
        self.lane(self.codebook[i >> self.geometry.lanes_log2()], i)
    }

    /// Index of a block. 32 of them fill `index_bits` words; one may lie in two.
    ///
    /// # Panics
    /// When there is no such block.
    #[must_use]
    #[inline]
    pub fn index_of(&self, block: [u32; 3]) -> u32 {
        let (grid, bits) = (&self.geometry.grid, self.geometry.index_bits);
        let b = (block[2] as usize * grid.y() as usize + block[1] as usize) * grid.x() as usize
            + block[0] as usize;
        unpack(self.index, bits, b)
    }

    /// First code of a block's codeword.
    #[must_use]
    #[inline]
    pub fn codeword(&self, block: [u32; 3]) -> usize {
        self.index_of(block) as usize * self.geometry.dimension() as usize
    }

    /// First code of a voxel, counted from the codeword's: `inside` is its place in the block.
    #[must_use]
    #[inline]
    pub fn place(&self, inside: [u32; 3]) -> usize {
        let [width, height, _] = self.geometry.block.0.to_array();
        (((inside[2] * height + inside[1]) * width + inside[0]) * self.geometry.channels) as usize
    }

    /// The voxel at `p`: its block's index, then one code per channel.
    ///
    /// # Panics
    /// When `p` lies outside.
    #[must_use]
    #[inline]
    pub fn fetch(&self, p: [u32; 3]) -> Voxel {
        let (block, inside) = split(self.geometry, p);
        let first = self.codeword(block) + self.place(inside);
        let mut out = [0.0; 4];
        for (c, out) in out.iter_mut().enumerate().take(self.geometry.channels as usize) {
            *out = self.value(self.code(first + c));
        }
        out
    }

    /// First codes of the codewords at both ends of a row of a cell, the index fetched once when they are in one
    /// block.
    #[inline]
    fn codewords(&self, from_x: u32, to_x: u32, y: u32, z: u32) -> [usize; 2] {
        let from = self.codeword([from_x, y, z]);
        if from_x == to_x {
            return [from, from];
        }
        [from, self.codeword([to_x, y, z])]
    }

    /// Two values of the codebook, the word fetched once when both are in it.
    #[inline]
    fn pair(&self, from: usize, to: usize) -> [f32; 2] {
        let lanes_log2 = self.geometry.lanes_log2();
        let from_word = self.codebook[from >> lanes_log2];
        let mut to_word = from_word;
        if to >> lanes_log2 != from >> lanes_log2 {
            to_word = self.codebook[to >> lanes_log2];
        }
        [self.value(self.lane(from_word, from)), self.value(self.lane(to_word, to))]
    }

    /// The corners of the cell from `p` to `q`: corner `i` takes x from bit 0, y from bit 1, z from bit 2 of `i`. Equal
    /// to eight calls of [`Frame::fetch`]; each block's index is fetched once.
    ///
    /// # Panics
    /// When a corner lies outside.
    #[must_use]
    #[inline]
    pub fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> [Voxel; 8] {
        let (from, a) = split(self.geometry, p);
        let (to, b) = split(self.geometry, q);
        let words_00 = self.codewords(from[0], to[0], from[1], from[2]);
        let mut words_10 = words_00;
        if to[1] != from[1] {
            words_10 = self.codewords(from[0], to[0], to[1], from[2]);
        }
        let mut words_01 = words_00;
        let mut words_11 = words_10;
        if to[2] != from[2] {
            words_01 = self.codewords(from[0], to[0], from[1], to[2]);
            words_11 = words_01;
            if to[1] != from[1] {
                words_11 = self.codewords(from[0], to[0], to[1], to[2]);
            }
        }
        let ends = |words: [usize; 2], y: u32, z: u32| {
            [words[0] + self.place([a[0], y, z]), words[1] + self.place([b[0], y, z])]
        };
        let rows = [
            ends(words_00, a[1], a[2]),
            ends(words_10, b[1], a[2]),
            ends(words_01, a[1], b[2]),
            ends(words_11, b[1], b[2]),
        ];
        let mut out = [[0.0; 4]; 8];
        for c in 0..self.geometry.channels as usize {
            for (row, out) in rows.iter().zip(out.chunks_exact_mut(2)) {
                let pair = self.pair(row[0] + c, row[1] + c);
                out[0][c] = pair[0];
                out[1][c] = pair[1];
            }
        }
        out
    }
}

/// Block that voxel `p` lies in, and where in it.
#[inline]
pub(crate) fn split(g: &Geometry, p: [u32; 3]) -> ([u32; 3], [u32; 3]) {
    let size = g.block.0.to_array();
    let block = [0, 1, 2].map(|a| p[a] / size[a]);
    (block, [0, 1, 2].map(|a| p[a] - block[a] * size[a]))
}
