//! One voxel out of the bits of its block: the twin of decode.wgsl, function for function. This one defines the codec.

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

/// A voxel: one value per channel, 0 where there is no channel.
pub type Voxel = [f32; 4];

/// Where the bits of a block begin: a word, and a bit of it.
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
    /// As it is stored: 1 is 2^(157 − exponent) units. 0 where all is 0.
    exponent: u32,
}

/// `count` bits (at most 32) from bit `at` of a block on; all must be the block's.
#[inline]
fn take(words: &[u32], place: Place, at: u32, count: u32) -> u32 {
    if count == 0 {
        return 0;
    }
    let bit = place.bit + at;
    let (word, shift) = (place.word + (bit >> 5) as usize, bit & 31);
    let mut bits = words[word] >> shift;
    if shift + count > 32 {
        bits |= words[word + 1] << (32 - shift);
    }
    bits & (u32::MAX >> (32 - count))
}

/// Coefficients from the lowest frequency on, in negabinary: planes from the highest down, until a block's bits end.
#[inline]
fn coefficients(words: &[u32], place: Place, block_bits: u32) -> [u32; 64] {
    let mut out = [0; 64];
    let (mut at, mut reached, mut plane) = (HEADER_BITS, 0, 32);
    while plane > 0 && at < block_bits {
        plane -= 1;
        let known = reached.min(block_bits - at);
        for first in (0..known).step_by(32) {
            let mut bits = take(words, place, at + first, (known - first).min(32));
            while bits != 0 {
                out[(first + bits.trailing_zeros()) as usize] |= 1 << plane;
                bits &= bits - 1;
            }
        }
        at += known;
        let mut announced = false;
        while at < block_bits && reached < 64 {
            let width = (block_bits - at).min(32);
            let (mut window, mut span) = (take(words, place, at, width), width);
            if !announced {
                at += 1;
                if window & 1 == 0 {
                    break;
                }
                window >>= 1;
                span -= 1;
            }
            // The last coefficient needs no bit: the test has told it.
            span = span.min(63 - reached);
            let zeros = window.trailing_zeros().min(span);
            reached += zeros;
            at += zeros + u32::from(zeros < span);
            announced = zeros == span && at < block_bits && reached < 63;
            if !announced {
                out[reached as usize] |= 1 << plane;
                reached += 1;
            }
        }
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
    /// A row along x, transformed back along y.
    #[inline]
    fn row(&self, y: usize, z: usize) -> [i32; 4] {
        [0, 1, 2, 3].map(|x| inverse([0, 4, 8, 12].map(|row| self.columns[row + x][z]))[y])
    }

    /// The value at a place in the block.
    #[inline]
    fn value(&self, [x, y, z]: [usize; 3]) -> f32 {
        value(inverse(self.row(y, z))[x], self.exponent)
    }

    /// All 64 values, x fastest: equal to as many calls of [`Block::value`].
    pub(crate) fn values(&self) -> [f32; 64] {
        let mut out = [0.0; 64];
        if self.exponent == 0 {
            return out;
        }
        for z in 0..4 {
            let columns = [0, 1, 2, 3].map(|x| inverse([0, 4, 8, 12].map(|row| self.columns[row + x][z])));
            for y in 0..4 {
                let row = inverse(columns.map(|column| column[y]));
                for (x, integer) in row.into_iter().enumerate() {
                    out[z * 16 + y * 4 + x] = value(integer, self.exponent);
                }
            }
        }
        out
    }
}

/// An integer as a single, rounded to nearest, ties to even, times 2^(exponent − 157): by integer means alone, so that no
/// device rounds or flushes otherwise. What is below the normal numbers is 0, what is above the largest is the largest.
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
    /// Where a block of a channel begins: 32 blocks fill `block_bits` words.
    #[inline]
    fn place(&self, block: [u32; 3], channel: u32) -> Place {
        let Geometry { grid, block_bits, .. } = self.geometry;
        let b = (block[2] as usize * grid.y() as usize + block[1] as usize) * grid.x() as usize
            + block[0] as usize;
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

    /// The voxel at `p`.
    ///
    /// # Panics
    /// When `p` lies outside.
    #[must_use]
    #[inline]
    pub fn fetch(&self, p: [u32; 3]) -> Voxel {
        let (block, inside) = split(p);
        let mut out = [0.0; 4];
        for (c, out) in (0..self.geometry.channels).zip(&mut out) {
            *out = self.block(block, c).value(inside);
        }
        out
    }

    /// The corners of the cell from `p` to `q`: corner `i` takes x from bit 0, y from bit 1, z from bit 2 of `i`. Equal
    /// to eight calls of [`Frame::fetch`]; each of the one to eight blocks is decoded once.
    ///
    /// # Panics
    /// When a corner lies outside.
    #[must_use]
    #[inline]
    pub fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> [Voxel; 8] {
        let ends = [split(p), split(q)];
        // Axes along which the cell reaches into another block.
        let crossed =
            (0..3).filter(|a| ends[0].0[*a] != ends[1].0[*a]).fold(0, |crossed, a| crossed | 1 << a);
        let of_end = |i: usize| [0, 1, 2].map(|a| &ends[i >> a & 1]);
        let mut out = [[0.0; 4]; 8];
        for c in 0..self.geometry.channels {
            for b in (0..8).filter(|b| b & !crossed == 0) {
                let [x, y, z] = of_end(b);
                let block = self.block([x.0[0], y.0[1], z.0[2]], c);
                for i in (0..8).filter(|i| i & crossed == b) {
                    let [x, y, z] = of_end(i);
                    out[i][c as usize] = block.value([x.1[0], y.1[1], z.1[2]]);
                }
            }
        }
        out
    }
}

/// Block that voxel `p` lies in, and where in it.
#[inline]
fn split(p: [u32; 3]) -> ([u32; 3], [usize; 3]) {
    (p.map(|v| v / EDGE), p.map(|v| (v % EDGE) as usize))
}

/// The values that bits of one block stand for.
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

    /// At the highest rate what is lost is what single precision and lifting round.
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
