//! One voxel out of its block: the twin of decode.wgsl, function for function. This one defines the codec.

use cvr_core::render::Cell;

use crate::block::{EDGE, PARTS};
use crate::{Geometry, Scale};

/// A thirty-fifth, rounded to single precision.
pub const PART: f32 = 1.0 / PARTS as f32;

/// One frame of a stream.
#[derive(Copy, Clone, Debug)]
pub struct Frame<'a> {
    /// The words of the frame.
    pub blocks: &'a [u32],
    /// Where blocks lie in them.
    pub geometry: &'a Geometry,
    /// What codes mean.
    pub scale: &'a Scale,
}

/// A voxel; channels that do not exist are 0.
pub type Voxel = [f32; 4];

/// Index of voxel `texel` of a block (x fastest).
#[must_use]
#[inline]
pub const fn index(words: [u32; 2], texel: u32) -> u32 {
    let bit = 16 + 3 * texel;
    if bit >= 32 {
        return (words[1] >> (bit - 32)) & 7;
    }
    // The sixth lies in both words; of the others, what comes from the second is masked.
    ((words[0] >> bit) | (words[1] << (32 - bit))) & 7
}

/// Level of an index of a block, in parts of a code ([`PARTS`]); an exact integer.
#[must_use]
#[inline]
pub const fn level(words: [u32; 2], index: u32) -> u32 {
    let (first, second) = (words[0] & 255, (words[0] >> 8) & 255);
    let eight = first > second;
    if !eight && index >= 6 {
        return (index - 6) * 255 * PARTS;
    }
    let whole = if eight { 7 } else { 5 };
    let share = match index {
        0 => 0,
        1 => whole,
        _ => index - 1,
    };
    ((whole - share) * first + share * second) * (PARTS / whole)
}

/// Value of a level, in data units: the float tail of the codec. A level that is a code is the same as that code of 8
/// bits in every bit.
#[must_use]
#[inline]
pub fn value(scale: &Scale, level: u32) -> f32 {
    let code = (level / PARTS) as f32 + (level % PARTS) as f32 * PART;
    (scale.offset + scale.step * code).min(scale.high)
}

/// Value of voxel `texel` of a block.
#[must_use]
#[inline]
pub fn voxel(scale: &Scale, words: [u32; 2], texel: u32) -> f32 {
    value(scale, level(words, index(words, texel)))
}

/// Place of a voxel in its block.
#[inline]
const fn texel(x: u32, y: u32) -> u32 {
    (y % EDGE) * EDGE + x % EDGE
}

impl Frame<'_> {
    /// The block of channel `c` that voxel `p` lies in.
    ///
    /// # Panics
    /// When `p` lies outside.
    #[must_use]
    #[inline]
    pub fn block(&self, p: [u32; 3], c: u32) -> [u32; 2] {
        let at = self.geometry.first_word(p, c);
        [self.blocks[at], self.blocks[at + 1]]
    }

    /// The voxel at `p`.
    ///
    /// # Panics
    /// When `p` lies outside.
    #[must_use]
    #[inline]
    pub fn fetch(&self, p: [u32; 3]) -> Voxel {
        let mut out = [0.0; 4];
        for c in 0..self.geometry.channels {
            let words = self.block(p, c);
            out[c as usize] = voxel(self.scale, words, texel(p[0], p[1]));
        }
        out
    }

    /// Channel `c` of the four corners of a cell in one slice; a block is fetched once for the corners that share it.
    #[inline]
    fn corners(&self, from: [u32; 2], to: [u32; 2], z: u32, c: u32) -> [f32; 4] {
        let across = to[0] / EDGE != from[0] / EDGE;
        let block_00 = self.block([from[0], from[1], z], c);
        let mut block_10 = block_00;
        if across {
            block_10 = self.block([to[0], from[1], z], c);
        }
        let mut block_01 = block_00;
        let mut block_11 = block_10;
        if to[1] / EDGE != from[1] / EDGE {
            block_01 = self.block([from[0], to[1], z], c);
            block_11 = block_01;
            if across {
                block_11 = self.block([to[0], to[1], z], c);
            }
        }
        [
            voxel(self.scale, block_00, texel(from[0], from[1])),
            voxel(self.scale, block_10, texel(to[0], from[1])),
            voxel(self.scale, block_01, texel(from[0], to[1])),
            voxel(self.scale, block_11, texel(to[0], to[1])),
        ]
    }

    /// The corners of the cell from `p` to `q`: corner `i` takes x from bit 0, y from bit 1, z from bit 2 of `i`. Equal
    /// to eight calls of [`Frame::fetch`].
    ///
    /// # Panics
    /// When a corner lies outside.
    #[must_use]
    pub fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> Cell {
        let mut out = Cell::default();
        for c in 0..self.geometry.channels {
            let near = self.corners([p[0], p[1]], [q[0], q[1]], p[2], c);
            let far = if q[2] == p[2] { near } else { self.corners([p[0], p[1]], [q[0], q[1]], q[2], c) };
            for i in 0..4 {
                out[i][c as usize] = near[i];
                out[i + 4][c as usize] = far[i];
            }
        }
        out
    }

    /// One row of voxels from `start` on: each block is fetched once.
    pub fn row(&self, start: [u32; 3], out: &mut [f32]) {
        let channels = self.geometry.channels as usize;
        let (mut x, mut rest) = (start[0], out);
        while !rest.is_empty() {
            let end = (x / EDGE + 1) * EDGE;
            let run = ((end - x) as usize * channels).min(rest.len());
            let (part, later) = rest.split_at_mut(run);
            for c in 0..self.geometry.channels {
                let words = self.block([x, start[1], start[2]], c);
                let voxels = part.iter_mut().skip(c as usize).step_by(channels);
                for (along, out) in (x..).zip(voxels) {
                    *out = voxel(self.scale, words, texel(along, start[1]));
                }
            }
            x = end;
            rest = later;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::{Ends, pack};

    const NATIVE: Scale = Scale { offset: 0.0, step: 1.0, high: 255.0 };

    /// Every pair of endpoints: every level is the integer that the encoder counts with, its value rounded twice at most,
    /// and in no bit another where it is a code.
    #[test]
    fn levels_are_those_of_the_encoder() {
        let indices = std::array::from_fn(|i| (i % 8) as u8);
        for (first, second) in (0..=255).flat_map(|a| (0..=255).map(move |b| (a, b))) {
            let ends = Ends([first, second]);
            let words = pack(ends, &indices);
            for (texel, level) in ends.levels().into_iter().enumerate() {
                assert_eq!(index(words, texel as u32), texel as u32);
                assert_eq!(index(words, texel as u32 + 8), texel as u32);
                assert_eq!(super::level(words, texel as u32), level as u32);
                let found = voxel(&NATIVE, words, texel as u32);
                let exact = f64::from(level) / f64::from(PARTS);
                assert!(
                    (f64::from(found) - exact).abs() <= exact * 1.5e-7,
                    "{first} {second} {texel}: {found}"
                );
                if level % PARTS as i16 == 0 {
                    assert_eq!(f64::from(found), exact, "{first} {second} {texel}");
                }
            }
        }
    }
}
