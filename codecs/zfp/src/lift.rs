//! The transform of four values, and the order of the 64 coefficients of a block.
//!
//! Lindstrom 2014, section 4.2, in the form of zfp's documentation: a nearly orthogonal transform by integer lifting
//! steps. A step loses the bits that it shifts out, so the inverse of the forward transform differs by units in the
//! last place.

/// Order of the coefficients, as columns along z: column `4·y + x`, from z = 0 on; 0 is the lowest frequency.
/// Coefficients are ordered by i + j + k, then by i² + j² + k² (zfp's documentation). Ties are in zfp's order.
pub const COLUMNS: [[u8; 4]; 16] = [
    [0, 3, 9, 19],
    [1, 5, 15, 30],
    [7, 12, 24, 42],
    [17, 27, 39, 52],
    [2, 4, 16, 31],
    [6, 10, 22, 37],
    [11, 20, 33, 49],
    [26, 35, 46, 58],
    [8, 13, 23, 43],
    [14, 21, 32, 50],
    [25, 34, 44, 56],
    [38, 45, 54, 61],
    [18, 28, 40, 51],
    [29, 36, 47, 57],
    [41, 48, 55, 60],
    [53, 59, 62, 63],
];

/// Four values to four coefficients, the lowest frequency first.
///
/// The rows of the matrix, in sixteenths: (4, 4, 4, 4), (5, 1, −1, −5), (−4, 4, 4, −4), (−2, 6, −6, 2).
#[must_use]
#[inline]
pub const fn forward([a, b, c, d]: [i32; 4]) -> [i32; 4] {
    let (outer, last) = split(a, d);
    let (inner, second) = split(c, b);
    let (mean, bow) = split(outer, inner);
    let (last, second) = split(last, second);
    let last = last.wrapping_add(second >> 1);
    [mean, second.wrapping_sub(last >> 1), bow, last]
}

/// Four coefficients to four values. Sums wrap: a truncated coefficient may need more than 31 bits.
///
/// The rows of the matrix, in quarters: (4, 6, −4, −1), (4, 2, 4, 5), (4, −2, 4, −5), (4, −6, −4, 1).
#[must_use]
#[inline]
pub const fn inverse([mean, slope, bow, wave]: [i32; 4]) -> [i32; 4] {
    let second = slope.wrapping_add(wave >> 1);
    let last = wave.wrapping_sub(second >> 1);
    let (last, second) = join(last, second);
    let (outer, inner) = join(mean, bow);
    let (c, b) = join(inner, second);
    let (a, d) = join(outer, last);
    [a, b, c, d]
}

/// The mean of two numbers, rounded down, and the second minus the first.
const fn split(p: i32, q: i32) -> (i32, i32) {
    let mean = p.wrapping_add(q) >> 1;
    (mean, q.wrapping_sub(mean))
}

/// Two numbers from their mean and the second minus the first. One bit of the first is lost.
const fn join(mean: i32, larger: i32) -> (i32, i32) {
    let q = mean.wrapping_add(larger);
    (mean.wrapping_add(mean).wrapping_sub(q), q)
}

/// The coefficients of a block of values, x fastest, counted from the lowest frequency.
#[must_use]
pub fn coefficients(values: &[i32; 64]) -> [i32; 64] {
    let mut v = *values;
    for (stride, starts) in LINES {
        for start in starts {
            let at = [0, 1, 2, 3].map(|k| start + k * stride);
            let line = forward(at.map(|i| v[i]));
            at.into_iter().zip(line).for_each(|(i, value)| v[i] = value);
        }
    }
    let mut out = [0; 64];
    for (column, places) in COLUMNS.iter().enumerate() {
        for (z, &place) in places.iter().enumerate() {
            out[usize::from(place)] = v[z * 16 + column];
        }
    }
    out
}

/// Lines along x, y and z in turn: the stride of a line, and the starts of the lines.
const LINES: [(usize, [usize; 16]); 3] = [
    (1, [0, 4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 44, 48, 52, 56, 60]),
    (4, [0, 1, 2, 3, 16, 17, 18, 19, 32, 33, 34, 35, 48, 49, 50, 51]),
    (16, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lifting_is_the_matrix_but_for_rounding() {
        const ROWS: [[i64; 4]; 4] = [[4, 4, 4, 4], [5, 1, -1, -5], [-4, 4, 4, -4], [-2, 6, -6, 2]];
        let mut state = 1_u32;
        for _ in 0..1000 {
            let values = [(); 4].map(|()| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                state as i32 >> 2
            });
            let found = forward(values);
            for (row, found) in ROWS.iter().zip(found) {
                let sum: i64 = row.iter().zip(values).map(|(m, v)| m * i64::from(v)).sum();
                assert!((sum as f64 / 16.0 - f64::from(found)).abs() <= 2.0, "{values:?}");
            }
            let back = inverse(found);
            assert!(values.iter().zip(back).all(|(v, b)| v.abs_diff(b) <= 8), "{values:?} {back:?}");
        }
    }

    #[test]
    fn coefficients_are_ordered_by_frequency() {
        let mut of_place = [[0_u32; 3]; 64];
        for (column, places) in (0..).zip(COLUMNS) {
            for (z, place) in (0..).zip(places) {
                of_place[usize::from(place)] = [column % 4, column / 4, z];
            }
        }
        let keys = of_place.map(|p| (p.iter().sum::<u32>(), p.iter().map(|i| i * i).sum::<u32>()));
        assert!(keys.is_sorted());
        assert_eq!(keys[1..].iter().filter(|k| k.0 == 0).count(), 0, "each place is taken once");
    }
}
