//! Decodes voxels and cells from the bits of their blocks. The twin of decode.wgsl, function for function. This code
//! defines the codec.

use cvr_core::kit::{FetchVoxels, Voxel, fill_from_blocks, number};
use cvr_core::render::Cell;
use cvr_core::volume::Region;

use crate::geometry::{EDGE, Geometry, HEADER_BITS};
use crate::lift::{COLUMNS, inverse};
use crate::planes::NEGABINARY;

/// One frame of a stream.
#[derive(Copy, Clone, Debug)]
pub struct Frame<'a> {
    /// Bits of all blocks, channel after channel: `geometry.channels · geometry.channel_words()` words.
    pub words: &'a [u32],
    /// Sizes.
    pub geometry: &'a Geometry,
}

/// Start of a block's bits: a word, and a bit in it.
#[derive(Copy, Clone, Debug)]
pub struct Place {
    word: usize,
    bit: u32,
}

/// A block of one channel, transformed back along z.
#[derive(Copy, Clone, Debug)]
pub struct Block {
    /// Block `4·y + x`, from z = 0 on.
    columns: [[i32; 4]; 16],
    /// The stored exponent: 1 is 2^(157 − exponent) units. 0 if all values are 0.
    exponent: u32,
}

/// `count` bits (at most 32) of a block, from bit `at` on. All must belong to the block.
#[inline]
fn take(words: &[u32], place: Place, at: u32, count: u32) -> u32 {
    number(words, place.word, place.bit + at, count)
}

/// Bit planes, the lowest first in the result. They are read from the highest down until the block's bits end. Bit `i`
/// of a plane's 64 bits belongs to coefficient `i`, counted from the lowest frequency.
#[inline]
fn planes(words: &[u32], place: Place, block_bits: u32) -> [[u32; 2]; 32] {
    let mut out = [[0; 2]; 32];
    let (mut at, mut reached) = (HEADER_BITS, 0);
    for out in out.iter_mut().rev() {
        if at >= block_bits {
            break;
        }
        let known = reached.min(block_bits - at);
        let mut low = take(words, place, at, known.min(32));
        let mut high = take(words, place, at + 32, known.max(32) - 32);
        at += known;
        let (mut announced, mut window, mut left) = (false, 0_u32, 0);
        while at < block_bits && reached < 64 {
            if left == 0 {
                left = (block_bits - at).min(32);
                window = take(words, place, at, left);
            }
            if !announced {
                at += 1;
                left -= 1;
                let any = window & 1;
                window >>= 1;
                if any == 0 {
                    break;
                }
            }
            // The last coefficient needs no bit: the group test implies it.
            let span = left.min(63 - reached);
            let zeros = window.trailing_zeros().min(span);
            let used = zeros + u32::from(zeros < span);
            reached += zeros;
            at += used;
            left -= used;
            // A window that is used up may be shifted by its whole width.
            window = window.wrapping_shr(used);
            announced = zeros == span && at < block_bits && reached < 63;
            if !announced {
                let bit = 1 << (reached & 31);
                low |= if reached < 32 { bit } else { 0 };
                high |= if reached < 32 { 0 } else { bit };
                reached += 1;
            }
        }
        *out = [low, high];
    }
    out
}

/// Transposes 32 words of 32 bits: bit `j` of word `i` becomes bit `i` of word `j`. Ever smaller squares are exchanged
/// across the diagonal (Warren, *Hacker's Delight*, section 7-3).
#[inline]
fn mirrored(mut words: [u32; 32]) -> [u32; 32] {
    let masks = [(16, 0xffff), (8, 0xff_00ff), (4, 0x0f0f_0f0f), (2, 0x3333_3333), (1, 0x5555_5555)];
    for (shift, low) in masks {
        for i in (0..32).filter(|i| i & shift == 0) {
            let other = ((words[i] >> shift) ^ words[i + shift]) & low;
            words[i] ^= other << shift;
            words[i + shift] ^= other;
        }
    }
    words
}

/// Coefficients from the lowest frequency on, in negabinary.
#[inline]
fn coefficients(words: &[u32], place: Place, block_bits: u32) -> [u32; 64] {
    let planes = planes(words, place, block_bits);
    let mut out = [0; 64];
    for (half, out) in out.chunks_exact_mut(32).enumerate() {
        out.copy_from_slice(&mirrored(planes.map(|plane| plane[half])));
    }
    out
}

/// A block, transformed back along z.
#[must_use]
#[inline]
pub(crate) fn column_block(words: &[u32], place: Place, block_bits: u32) -> Block {
    let mut out = Block { columns: [[0; 4]; 16], exponent: 0 };
    let header = take(words, place, 0, HEADER_BITS);
    if header & 1 == 0 {
        return out;
    }
    out.exponent = header >> 1;
    let c = coefficients(words, place, block_bits);
    for (column, places) in out.columns.iter_mut().zip(COLUMNS) {
        *column = inverse(places.map(|i| (c[usize::from(i)] ^ NEGABINARY).wrapping_sub(NEGABINARY) as i32));
    }
    out
}

impl Block {
    /// Four lines along y, one for each x: a slice, transformed back along z and y.
    #[inline]
    fn slice(&self, z: usize) -> [[i32; 4]; 4] {
        [0, 1, 2, 3].map(|x| inverse([0, 4, 8, 12].map(|row| self.columns[row + x][z])))
    }

    /// The value at a place in the block.
    #[inline]
    fn value(&self, [x, y, z]: [usize; 3]) -> f32 {
        value(row(&self.slice(z), y)[x], self.exponent)
    }

    /// Values at the ends of a cell's four rows along x, all in this block. In a row's number, bit 0 is y and bit 1 is
    /// z.
    #[inline]
    fn ends(&self, low: [usize; 3], high: [usize; 3]) -> [[f32; 2]; 4] {
        let slices = [self.slice(low[2]), self.slice(high[2])];
        [0, 1, 2, 3].map(|i: usize| {
            let row = row(&slices[i >> 1], if i & 1 == 1 { high[1] } else { low[1] });
            [low[0], high[0]].map(|x| value(row[x], self.exponent))
        })
    }

    /// All 64 values, x fastest. Equal to 64 calls of [`Block::value`].
    pub(crate) fn values(&self) -> [f32; 64] {
        let mut out = [0.0; 64];
        if self.exponent == 0 {
            return out;
        }
        for z in 0..4 {
            let slice = self.slice(z);
            for y in 0..4 {
                for (x, integer) in row(&slice, y).into_iter().enumerate() {
                    out[z * 16 + y * 4 + x] = value(integer, self.exponent);
                }
            }
        }
        out
    }
}

/// A row along x, transformed back.
#[inline]
fn row(slice: &[[i32; 4]; 4], y: usize) -> [i32; 4] {
    inverse(slice.map(|line| line[y]))
}

/// An integer as a single, rounded to nearest, ties to even, times 2^(exponent − 157). Only integer arithmetic is used,
/// so no device rounds or flushes differently. Values below the normal numbers become 0; values above the largest
/// number become the largest.
#[must_use]
#[inline]
pub(crate) fn value(integer: i32, exponent: u32) -> f32 {
    let magnitude = integer.unsigned_abs();
    if magnitude == 0 {
        return 0.0;
    }
    let sign = (integer as u32) & 0x8000_0000;
    let top = magnitude.ilog2();
    let mut mantissa = magnitude << (23_u32.saturating_sub(top));
    if top > 23 {
        let shift = top - 23;
        mantissa = (magnitude + ((1 << (shift - 1)) - 1) + ((magnitude >> shift) & 1)) >> shift;
    }
    // Biased exponent, plus 30 so that it is not negative.
    let raised = top + exponent;
    if raised < 30 {
        return 0.0;
    }
    if raised >= 30 + 255 {
        return f32::from_bits(sign | 0x7f7f_ffff);
    }
    // A mantissa that was rounded up to 2^24 carries into the exponent.
    let bits = ((raised - 30) << 23) + mantissa - 0x80_0000;
    if bits < 0x80_0000 {
        return 0.0;
    }
    f32::from_bits(sign | bits.min(0x7f7f_ffff))
}

impl Frame<'_> {
    /// Start of a block of a channel. 32 blocks fill `block_bits` words.
    #[inline]
    fn place(&self, block: [u32; 3], channel: u32) -> Place {
        let Geometry { grid, block_bits, .. } = self.geometry;
        let b = grid.number(block);
        let bit = (b & 31) as u32 * block_bits;
        let first = channel as usize * self.geometry.channel_words() as usize;
        Place { word: first + (b >> 5) * *block_bits as usize + (bit >> 5) as usize, bit: bit & 31 }
    }

    /// A block of a channel, transformed back along z.
    ///
    /// # Panics
    /// When there is no such block.
    #[must_use]
    #[inline]
    pub fn block(&self, block: [u32; 3], channel: u32) -> Block {
        column_block(self.words, self.place(block, channel), self.geometry.block_bits)
    }
}

impl FetchVoxels for Frame<'_> {
    fn channels(&self) -> usize {
        self.geometry.channels as usize
    }

    #[inline]
    fn fetch(&self, p: [u32; 3]) -> Voxel {
        let (block, inside) = split(p);
        let mut out = [0.0; 4];
        for (c, out) in (0..self.geometry.channels).zip(&mut out) {
            *out = self.block(block, c).value(inside);
        }
        out
    }

    /// Decodes each of the one to eight blocks once.
    #[inline]
    fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> Cell {
        // Axes along which the cell reaches into another block.
        let crossed = [0, 1, 2].map(|a| u32::from(p[a] / EDGE != q[a] / EDGE));
        let shifts = [0, crossed[0], crossed[0] + crossed[1]];
        let mut out = [[0.0; 4]; 8];
        for c in 0..self.geometry.channels {
            for k in 0..1_u32 << (shifts[2] + crossed[2]) {
                let side = [0, 1, 2].map(|a| (k >> shifts[a]) & crossed[a]);
                let from = [0, 1, 2].map(|a| if side[a] == 0 { p[a] } else { q[a] });
                let to = [0, 1, 2].map(|a| if side[a] == crossed[a] { q[a] } else { p[a] });
                let (block, low) = split(from);
                let ends = self.block(block, c).ends(low, split(to).1);
                for (i, out) in out.iter_mut().enumerate() {
                    // Along each crossed axis, the corner's end must lie in this block.
                    if (0..3).all(|a| crossed[a] == 0 || (i >> a & 1) as u32 == side[a]) {
                        out[c as usize] = ends[i >> 1][i & 1];
                    }
                }
            }
        }
        out
    }

    fn fetch_box(&self, region: Region, out: &mut [f32]) {
        let values = |block, c| self.block(block, c as u32).values();
        fill_from_blocks(&self.geometry.grid, region, self.channels(), out, values);
    }
}

/// The block of voxel `p`, and the position of `p` in it.
#[inline]
fn split(p: [u32; 3]) -> ([u32; 3], [usize; 3]) {
    (p.map(|v| v / EDGE), p.map(|v| (v % EDGE) as usize))
}

/// The values of one block's bits.
#[must_use]
pub(crate) fn decoded(words: &[u32], block_bits: u32) -> [f32; 64] {
    column_block(words, Place { word: 0, bit: 0 }, block_bits).values()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planes::BlockBits;

    #[test]
    fn a_value_is_the_integer_rounded_once() {
        let mut state = 7_u32;
        for i in 0..200_000_u32 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let integer = (state as i32) >> (i % 32);
            for exponent in [1, 30, 127, 128, 157, 200, 226] {
                let exact = f64::from(integer as f32) * 2_f64.powi(exponent - 157);
                let kept = if exact.abs() < f64::from(f32::MIN_POSITIVE) { 0.0 } else { exact as f32 };
                assert_eq!(value(integer, exponent as u32), kept, "{integer} {exponent}");
            }
        }
    }

    #[test]
    fn no_integer_and_exponent_is_infinite() {
        for integer in [i32::MIN, i32::MAX, 1 << 30, (1 << 30) - 1, (1 << 29) + 1] {
            for exponent in 0..256 {
                assert!(value(integer, exponent).is_finite(), "{integer} {exponent}");
            }
        }
        assert_eq!(value(i32::MIN, 255), f32::MIN);
        assert_eq!(value((1 << 30) - 1, 255), f32::MAX);
        assert_eq!(value((1 << 30) - 64, 255), f32::MAX);
    }

    /// At the highest rate, only the rounding of single precision and lifting is lost.
    #[test]
    fn many_bits_give_the_values_back() {
        let values: [f32; 64] = std::array::from_fn(|i| ((i * 2_654_435_761) % 1013) as f32 - 500.0);
        let mut last = f32::INFINITY;
        for rate in [1, 2, 4, 8, 16, 24, 32] {
            let back = decoded(BlockBits::of(&values, rate * 64).words(), rate * 64);
            let worst = values.iter().zip(back).map(|(v, b)| (v - b).abs()).fold(0.0, f32::max);
            assert!(worst < last || worst < 1e-5, "rate {rate}: {worst} after {last}");
            last = worst;
        }
        assert!(last < 1e-4, "{last}");
    }
}
