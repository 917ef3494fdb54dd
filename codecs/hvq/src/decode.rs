//! One voxel out of a mean, two indices and two codewords: the twin of decode.wgsl, function for function. This one
//! defines the codec.

use cvr_codebook::pack::unpack;

use crate::geometry::{EDGE, Geometry, Plane};

/// One frame of a stream at a level.
#[derive(Copy, Clone, Debug)]
pub struct Frame<'a> {
    /// Means and indices: `geometry.index_words()` words.
    pub index: &'a [u32],
    /// The codewords that serve this frame: `geometry.table_words()` words.
    pub codebook: &'a [u32],
    /// Sizes.
    pub geometry: &'a Geometry,
    /// Stages to sum: the mean, coarse differences from 2 on, and fine ones from 3 on.
    pub stages: u8,
}

/// A voxel: one value per channel, 0 where there is no channel.
pub type Voxel = [f32; 4];

/// What a block has for all of its voxels: its number, and the first codes of its two codewords.
pub type Head = [usize; 3];

impl Frame<'_> {
    /// Value of a sum of levels, in data units: the only float expression of the codec.
    #[must_use]
    #[inline]
    pub fn value(&self, level: i32) -> f32 {
        self.geometry.levels.value(level.clamp(0, self.geometry.top as i32) as u32)
    }

    /// Number `i` of a plane. 32 of them fill as many words as they have bits; one may lie in two.
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
        self.lane(self.codebook[first as usize + (i >> self.geometry.lanes_log2())], i)
    }

    /// Code `i` out of the word that holds it.
    #[inline]
    fn lane(&self, word: u32, i: usize) -> i32 {
        let bits = self.geometry.codeword_bits;
        let lane = i as u32 & ((1 << self.geometry.lanes_log2()) - 1);
        ((word >> (lane * bits)) & ((1 << bits) - 1)) as i32
    }

    /// The head of a block.
    ///
    /// # Panics
    /// When there is no such block.
    #[must_use]
    #[inline]
    pub fn head(&self, block: [u32; 3]) -> Head {
        let g = self.geometry;
        let b = (block[2] as usize * g.grid.y() as usize + block[1] as usize) * g.grid.x() as usize
            + block[0] as usize;
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

    /// First code of a voxel's sub-block, counted from the coarse codeword's; `inside` is the voxel's place in the block.
    #[must_use]
    #[inline]
    pub fn sub_block(&self, inside: [u32; 3]) -> usize {
        let sub = ((inside[2] & 2) << 1) | (inside[1] & 2) | (inside[0] >> 1);
        (sub * self.geometry.channels) as usize
    }

    /// First code of a voxel, counted from the detail codeword's.
    #[must_use]
    #[inline]
    pub fn place(&self, inside: [u32; 3]) -> usize {
        (((inside[2] * EDGE + inside[1]) * EDGE + inside[0]) * self.geometry.channels) as usize
    }

    /// Channel `c` of the voxel at `inside` of a block.
    ///
    /// # Panics
    /// When there is no such block.
    #[must_use]
    #[inline]
    pub fn voxel(&self, head: Head, inside: [u32; 3], c: usize) -> f32 {
        let mut level = self.mean(head[0], c);
        if self.stages > 1 {
            level += self.coarse(self.code(self.geometry.coarse.first, head[1] + self.sub_block(inside) + c));
        }
        if self.stages > 2 {
            level += self.detail(self.code(self.geometry.detail.first, head[2] + self.place(inside) + c));
        }
        self.value(level)
    }

    /// The voxel at `p`.
    ///
    /// # Panics
    /// When `p` lies outside.
    #[must_use]
    #[inline]
    pub fn fetch(&self, p: [u32; 3]) -> Voxel {
        let head = self.head(p.map(|p| p / EDGE));
        let mut out = [0.0; 4];
        for (c, out) in out.iter_mut().enumerate().take(self.geometry.channels as usize) {
            *out = self.voxel(head, p.map(|p| p % EDGE), c);
        }
        out
    }

    /// Heads of the blocks at both ends of a row of a cell, fetched once when they are one block.
    #[inline]
    fn heads(&self, low_x: u32, high_x: u32, y: u32, z: u32) -> [Head; 2] {
        let low = self.head([low_x, y, z]);
        if low_x == high_x {
            return [low, low];
        }
        [low, self.head([high_x, y, z])]
    }

    /// Two codes of the codewords whose first word is `first`, the word fetched once when both are in it.
    #[inline]
    fn code_pair(&self, first: u64, low: usize, high: usize) -> [i32; 2] {
        let lanes_log2 = self.geometry.lanes_log2();
        let low_word = self.codebook[first as usize + (low >> lanes_log2)];
        let mut high_word = low_word;
        if high >> lanes_log2 != low >> lanes_log2 {
            high_word = self.codebook[first as usize + (high >> lanes_log2)];
        }
        [self.lane(low_word, low), self.lane(high_word, high)]
    }

    /// Levels of the means of channel `c` at both ends of a row, fetched once when they are one block's.
    #[inline]
    fn means(&self, heads: [Head; 2], c: usize) -> [i32; 2] {
        let low = self.mean(heads[0][0], c);
        if heads[0][0] == heads[1][0] {
            return [low, low];
        }
        [low, self.mean(heads[1][0], c)]
    }

    /// Channel `c` at both ends of a row, `a` and `b` being their places in their blocks.
    #[inline]
    fn pair(&self, heads: [Head; 2], means: [i32; 2], a: [u32; 3], b: [u32; 3], c: usize) -> [f32; 2] {
        let [low, high] = heads;
        let mut levels = means;
        if self.stages > 1 {
            let (low, high) = (low[1] + self.sub_block(a) + c, high[1] + self.sub_block(b) + c);
            let codes = self.code_pair(self.geometry.coarse.first, low, high);
            levels[0] += self.coarse(codes[0]);
            levels[1] += self.coarse(codes[1]);
        }
        if self.stages > 2 {
            let (low, high) = (low[2] + self.place(a) + c, high[2] + self.place(b) + c);
            let codes = self.code_pair(self.geometry.detail.first, low, high);
            levels[0] += self.detail(codes[0]);
            levels[1] += self.detail(codes[1]);
        }
        levels.map(|level| self.value(level))
    }

    /// The corners of the cell from `p` to `q`: corner `i` takes x from bit 0, y from bit 1, z from bit 2 of `i`. Equal
    /// to eight calls of [`Frame::fetch`]; each block's indices are fetched once.
    ///
    /// # Panics
    /// When a corner lies outside.
    #[must_use]
    #[inline]
    pub fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> [Voxel; 8] {
        let (from, to) = (p.map(|p| p / EDGE), q.map(|q| q / EDGE));
        let (a, b) = (p.map(|p| p % EDGE), q.map(|q| q % EDGE));
        let (across_y, across_z) = (to[1] != from[1], to[2] != from[2]);
        let heads_00 = self.heads(from[0], to[0], from[1], from[2]);
        let mut heads_10 = heads_00;
        if across_y {
            heads_10 = self.heads(from[0], to[0], to[1], from[2]);
        }
        let mut heads_01 = heads_00;
        let mut heads_11 = heads_10;
        if across_z {
            heads_01 = self.heads(from[0], to[0], from[1], to[2]);
            heads_11 = heads_01;
            if across_y {
                heads_11 = self.heads(from[0], to[0], to[1], to[2]);
            }
        }
        let mut out = [[0.0; 4]; 8];
        for c in 0..self.geometry.channels as usize {
            let means_00 = self.means(heads_00, c);
            let means_10 = if across_y { self.means(heads_10, c) } else { means_00 };
            let means_01 = if across_z { self.means(heads_01, c) } else { means_00 };
            let means_11 = match (across_y, across_z) {
                (true, true) => self.means(heads_11, c),
                (true, false) => means_10,
                (false, _) => means_01,
            };
            let rows = [
                (heads_00, means_00, a[1], a[2]),
                (heads_10, means_10, b[1], a[2]),
                (heads_01, means_01, a[1], b[2]),
                (heads_11, means_11, b[1], b[2]),
            ];
            for ((heads, means, y, z), out) in rows.into_iter().zip(out.chunks_exact_mut(2)) {
                let pair = self.pair(heads, means, [a[0], y, z], [b[0], y, z], c);
                out[0][c] = pair[0];
                out[1][c] = pair[1];
            }
        }
        out
    }
}
