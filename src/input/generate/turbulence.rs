//! Turbulence in K. Perlin's sense (SIGGRAPH 1985): the sum of `|noise|` over octaves, each with twice the
//! frequency and half the amplitude of the one before. The noise is value noise, and all of it, lattice
//! values, positions, fading and sum, is integer arithmetic: the same bits on every machine.

use cvr_core::volume::Extent;

use super::Signal;

const OCTAVES: u32 = 5;
/// Lattice cells along each axis of the unit cube in the first octave.
const FIRST_CELLS: u64 = 4;
/// Largest absolute lattice value: noise runs from −`AMPLITUDE` to `AMPLITUDE` − 1.
const AMPLITUDE: i64 = 1 << 15;
/// The sum over all octaves when each is at its largest: 2^15 + 2^14 + … .
const LARGEST_SUM: i64 = 2 * AMPLITUDE - (AMPLITUDE >> (OCTAVES - 1));

pub(super) struct Turbulence {
    extent: Extent,
    seed: u64,
}

impl Turbulence {
    pub const fn new(extent: Extent, seed: u64) -> Self {
        Self { extent, seed }
    }

    /// Noise of one octave at a lattice point.
    fn lattice(&self, octave: u32, [x, y, z]: [u64; 3]) -> i64 {
        let key = [u64::from(octave), x, y, z].into_iter().fold(self.seed, |h, c| mix(h ^ c));
        (key >> 48) as i64 - AMPLITUDE
    }

    /// Noise on the lattice line through `x`, faded along y and z.
    fn column(&self, octave: u32, x: u64, (cy, ty): (u64, i64), (cz, tz): (u64, i64)) -> i64 {
        let at = |y, z| self.lattice(octave, [x, y, z]);
        let near = lerp(at(cy, cz), at(cy + 1, cz), ty);
        let far = lerp(at(cy, cz + 1), at(cy + 1, cz + 1), ty);
        lerp(near, far, tz)
    }
}

impl Signal for Turbulence {
    fn fill_row(&self, y: u32, z: u32, row: &mut [f64]) {
        row.fill(0.0);
        for octave in 0..OCTAVES {
            let cells = FIRST_CELLS << octave;
            let y = position(y, self.extent.y(), cells);
            let z = position(z, self.extent.z(), cells);
            let mut columns = None;
            for (v, i) in row.iter_mut().zip(0..) {
                let (cell, t) = position(i, self.extent.x(), cells);
                // Many voxels share a cell: the two lattice lines around it are computed once.
                let (left, right) = match columns {
                    Some((c, left, right)) if c == cell => (left, right),
                    _ => (self.column(octave, cell, y, z), self.column(octave, cell + 1, y, z)),
                };
                columns = Some((cell, left, right));
                // Sums of small integers are exact in double precision.
                *v += (lerp(left, right, t).abs() >> octave) as f64;
            }
        }
        for v in row {
            *v /= LARGEST_SUM as f64;
        }
    }
}

/// Cell of voxel centre `(i + ½) / n` on a lattice of `cells` cells, and the faded place within it in 2^-16.
fn position(i: u32, n: u32, cells: u64) -> (u64, i64) {
    // At most 2^33 · 2^6 · 2^16: no overflow.
    let fixed = (((2 * u64::from(i) + 1) * cells) << 16) / (2 * u64::from(n));
    let t = (fixed & 0xffff) as i64;
    // 3t² − 2t³ joins the cells without a crease.
    (fixed >> 16, (t * t * ((3 << 16) - 2 * t)) >> 32)
}

/// From `a` to `b` by `t` in 2^-16, rounded down.
const fn lerp(a: i64, b: i64, t: i64) -> i64 {
    a + (((b - a) * t) >> 16)
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014): every input bit reaches every output bit.
pub(super) const fn mix(h: u64) -> u64 {
    let h = h.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let h = (h ^ (h >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let h = (h ^ (h >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    h ^ (h >> 31)
}
