//! One voxel out of the two volumes: the twin of decode.wgsl, function for function. This one defines the codec.

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

/// A voxel: one value per channel, 0 where there is no channel.
pub type Voxel = [f32; 4];

impl Frame<'_> {
    /// An endpoint of an integer type, from its code in the low bits.
    #[inline]
    fn integer(&self, code: u32) -> f32 {
        let shift = 32 - self.geometry.endpoint.bits;
        let high = code << shift;
        if self.geometry.endpoint.signed {
            return (high as i32 >> shift) as f32;
        }
        (high >> shift) as f32
    }

    /// Minimum and maximum of an entry (block in memory order × channels + channel).
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

    /// Equation 2 of the paper: the only float expression of the codec.
    #[must_use]
    #[inline]
    pub fn value(&self, ends: [f32; 2], index: u32) -> f32 {
        value(ends, index, self.geometry.reciprocal)
    }

    /// First entry of a block.
    #[must_use]
    #[inline]
    pub fn entry(&self, block: [u32; 3]) -> usize {
        let grid = &self.geometry.grid;
        let row = block[2] as usize * grid.y() as usize + block[1] as usize;
        (row * grid.x() as usize + block[0] as usize) * self.geometry.channels as usize
    }

    /// First word of a row of indices.
    #[must_use]
    #[inline]
    pub fn row(&self, y: u32, z: u32) -> usize {
        (z as usize * self.geometry.extent.y() as usize + y as usize) * self.geometry.row_words as usize
    }

    /// The voxel at `p`: two fetches per channel.
    ///
    /// # Panics
    /// When `p` lies outside.
    #[must_use]
    #[inline]
    pub fn fetch(&self, p: [u32; 3]) -> Voxel {
        let g = self.geometry;
        let entry = self.entry(block_of(g, p));
        let row = self.row(p[1], p[2]);
        let mut out = [0.0; 4];
        for c in 0..g.channels {
            let bit = (p[0] as usize * g.channels as usize + c as usize) * g.index_bits as usize;
            let word = self.index[row + (bit >> 5)];
            let index = (word >> (bit & 31)) & g.levels();
            out[c as usize] = self.value(self.endpoints(entry + c as usize), index);
        }
        out
    }

    /// Endpoints of channel `c` at both ends of a row of a cell, fetched once when they are in one block.
    #[inline]
    fn ends(&self, from_x: u32, to_x: u32, y: u32, z: u32, c: u32) -> [[f32; 2]; 2] {
        let from = self.endpoints(self.entry([from_x, y, z]) + c as usize);
        if from_x == to_x {
            return [from, from];
        }
        [from, self.endpoints(self.entry([to_x, y, z]) + c as usize)]
    }

    /// Channel `c` at both ends of a row of a cell; the index word is fetched once when both are in it.
    #[inline]
    fn pair(&self, ends: [[f32; 2]; 2], row: usize, from: u32, to: u32, c: u32) -> [f32; 2] {
        let g = self.geometry;
        let bit = |x: u32| (x as usize * g.channels as usize + c as usize) * g.index_bits as usize;
        let (from_bit, to_bit) = (bit(from), bit(to));
        let from_word = self.index[row + (from_bit >> 5)];
        let mut to_word = from_word;
        if to_bit >> 5 != from_bit >> 5 {
            to_word = self.index[row + (to_bit >> 5)];
        }
        let from_index = (from_word >> (from_bit & 31)) & g.levels();
        let to_index = (to_word >> (to_bit & 31)) & g.levels();
        [self.value(ends[0], from_index), self.value(ends[1], to_index)]
    }

    /// The corners of the cell from `p` to `q` ("optimised linear", section 4.3): corner `i` takes x from bit 0, y
    /// from bit 1, z from bit 2 of `i`. Equal to eight calls of [`Frame::fetch`].
    ///
    /// # Panics
    /// When a corner lies outside.
    #[must_use]
    #[inline]
    pub fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> [Voxel; 8] {
        let g = self.geometry;
        let (from, to) = (block_of(g, p), block_of(g, q));
        let mut out = [[0.0; 4]; 8];
        for c in 0..g.channels {
            let ends_00 = self.ends(from[0], to[0], from[1], from[2], c);
            let mut ends_10 = ends_00;
            if to[1] != from[1] {
                ends_10 = self.ends(from[0], to[0], to[1], from[2], c);
            }
            let mut ends_01 = ends_00;
            let mut ends_11 = ends_10;
            if to[2] != from[2] {
                ends_01 = self.ends(from[0], to[0], from[1], to[2], c);
                ends_11 = ends_01;
                if to[1] != from[1] {
                    ends_11 = self.ends(from[0], to[0], to[1], to[2], c);
                }
            }
            let pairs = [
                self.pair(ends_00, self.row(p[1], p[2]), p[0], q[0], c),
                self.pair(ends_10, self.row(q[1], p[2]), p[0], q[0], c),
                self.pair(ends_01, self.row(p[1], q[2]), p[0], q[0], c),
                self.pair(ends_11, self.row(q[1], q[2]), p[0], q[0], c),
            ];
            for (i, pair) in pairs.into_iter().enumerate() {
                out[2 * i][c as usize] = pair[0];
                out[2 * i + 1][c as usize] = pair[1];
            }
        }
        out
    }
}

/// Equation 2 with the division turned into a product: `min + (max − min)·index/(2^i − 1)`, held at the maximum,
/// which rounding might pass.
#[inline]
pub(crate) fn value(ends: [f32; 2], index: u32, reciprocal: f32) -> f32 {
    (ends[0] + (ends[1] - ends[0]) * (index as f32 * reciprocal)).min(ends[1])
}

/// Block that voxel `p` lies in.
#[inline]
fn block_of(g: &Geometry, p: [u32; 3]) -> [u32; 3] {
    let [x, y, z] = g.block.0.to_array();
    [p[0] / x, p[1] / y, p[2] / z]
}
