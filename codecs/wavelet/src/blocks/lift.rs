//! The transform of a block: integers to as many coefficients, and back. Additions wrap, as they do in a shader, so no
//! stream overflows.

use super::Filter;

/// Longest edge of a block.
const LONGEST: usize = 16;

/// A line of `2 m` samples becomes `m` low-pass and `m` high-pass coefficients.
fn split(filter: Filter, line: &mut [i32]) {
    let (n, m) = (line.len(), line.len() / 2);
    let mut x = [0_i32; LONGEST];
    x[..n].copy_from_slice(line);
    let (low, high) = line.split_at_mut(m);
    match filter {
        Filter::Haar => {
            for i in 0..m {
                high[i] = x[2 * i].wrapping_sub(x[2 * i + 1]);
                low[i] = x[2 * i + 1].wrapping_add(high[i] >> 1);
            }
        }
        Filter::FiveThree => {
            for i in 0..m {
                // Beyond its ends, a line is mirrored in its last sample.
                let after = if i + 1 < m { x[2 * i + 2] } else { x[2 * i] };
                high[i] = x[2 * i + 1].wrapping_sub(x[2 * i].wrapping_add(after) >> 1);
            }
            for i in 0..m {
                low[i] = x[2 * i].wrapping_add(correction(high[i.max(1) - 1], high[i]));
            }
        }
    }
}

/// The inverse of [`split`].
fn join(filter: Filter, line: &mut [i32]) {
    let m = line.len() / 2;
    let mut x = [0_i32; LONGEST];
    let (low, high) = line.split_at(m);
    match filter {
        Filter::Haar => {
            for i in 0..m {
                x[2 * i + 1] = low[i].wrapping_sub(high[i] >> 1);
                x[2 * i] = x[2 * i + 1].wrapping_add(high[i]);
            }
        }
        Filter::FiveThree => {
            for i in 0..m {
                x[2 * i] = low[i].wrapping_sub(correction(high[i.max(1) - 1], high[i]));
            }
            for i in 0..m {
                let after = if i + 1 < m { x[2 * i + 2] } else { x[2 * i] };
                x[2 * i + 1] = high[i].wrapping_add(x[2 * i].wrapping_add(after) >> 1);
            }
        }
    }
    let n = line.len();
    line.copy_from_slice(&x[..n]);
}

/// What 5/3 adds to an even sample, from the high-pass coefficients before and after it.
#[inline]
pub const fn correction(before: i32, after: i32) -> i32 {
    before.wrapping_add(after).wrapping_add(2) >> 2
}

/// Applies `map` to all lines along an axis of the cube of `n` at the start of a block.
fn lines(block: &mut [i32], edge: usize, n: usize, axis: usize, map: impl Fn(&mut [i32])) {
    let strides = [1, edge, edge * edge];
    let (along, [u, v]) = (strides[axis], [strides[(axis + 1) % 3], strides[(axis + 2) % 3]]);
    let mut line = [0_i32; LONGEST];
    for a in 0..n {
        for b in 0..n {
            let first = a * u + b * v;
            for (i, out) in line[..n].iter_mut().enumerate() {
                *out = block[first + i * along];
            }
            map(&mut line[..n]);
            for (i, value) in line[..n].iter().enumerate() {
                block[first + i * along] = *value;
            }
        }
    }
}

/// Transforms a block of `edge`³ samples, x fastest, in place. At each level the low-pass half of each axis comes
/// first: along z, then y, then x.
pub fn forward(filter: Filter, edge: usize, block: &mut [i32]) {
    let mut n = edge;
    while n > 1 {
        for axis in [2, 1, 0] {
            lines(block, edge, n, axis, |line| split(filter, line));
        }
        n /= 2;
    }
}

/// The inverse of [`forward`].
pub fn inverse(filter: Filter, edge: usize, block: &mut [i32]) {
    let mut n = 2;
    while n <= edge {
        for axis in [0, 1, 2] {
            lines(block, edge, n, axis, |line| join(filter, line));
        }
        n *= 2;
    }
}

/// How strongly an error of one coefficient shows in the samples of a line: the root of the sum of squares, without
/// rounding, of a low-pass and of a high-pass coefficient after `depth` decompositions (at least 1) of a line of `edge`
/// samples. The mean over all coefficients, because those at the ends differ.
pub fn norms(filter: Filter, edge: usize, depth: usize) -> [f64; 2] {
    // Large enough that rounding does not matter.
    const UNIT: i32 = 1 << 24;
    let m = edge >> depth;
    [0, m].map(|half| {
        let squares = (0..m).map(|i| {
            let mut line = vec![0_i32; edge];
            line[half + i] = UNIT;
            let mut n = 2 * m;
            while n <= edge {
                join(filter, &mut line[..n]);
                n *= 2;
            }
            line.iter().map(|v| (f64::from(*v) / f64::from(UNIT)).powi(2)).sum::<f64>()
        });
        (squares.sum::<f64>() / m as f64).sqrt()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILTERS: [Filter; 2] = [Filter::Haar, Filter::FiveThree];

    #[test]
    fn every_block_comes_back() {
        for filter in FILTERS {
            for edge in [2_usize, 4, 8, 16] {
                let block: Vec<i32> = (0..edge.pow(3) as u32)
                    .map(|i| (i.wrapping_mul(0x9e37_79b9) >> (i % 31)) as i32)
                    .collect();
                let mut back = block.clone();
                forward(filter, edge, &mut back);
                assert_ne!(back, block);
                inverse(filter, edge, &mut back);
                assert_eq!(back, block, "{filter:?} {edge}");
            }
        }
    }

    #[test]
    fn a_constant_is_one_coefficient_and_5_3_keeps_a_ramp_low() {
        for filter in FILTERS {
            let mut block = vec![-77; 512];
            forward(filter, 8, &mut block);
            assert!(block[0] == -77 && block[1..].iter().all(|c| *c == 0));
        }
        let mut ramp: Vec<i32> = (0..8).map(|x| 40 * x).collect();
        split(Filter::FiveThree, &mut ramp);
        // Only the mirrored end has a slope of its own.
        assert_eq!(ramp[4..], [0, 0, 0, 40]);
    }

    #[test]
    fn norms_are_those_of_the_filters() {
        let near = |found: [f64; 2], expected: [f64; 2]| {
            found
                .iter()
                .zip(expected)
                .for_each(|(f, e)| assert!((f - e).abs() < 1e-6, "{found:?} {expected:?}"));
        };
        let half = 0.5_f64.sqrt();
        near(norms(Filter::Haar, 8, 1), [2.0 * half, half]);
        near(norms(Filter::Haar, 8, 3), [8.0_f64.sqrt(), 2_f64.sqrt()]);
        // Inside a long line: ½ 1 ½, and −⅛ −¼ ¾ −¼ −⅛. The ends of sixteen samples change them a little.
        let [low, high] = norms(Filter::FiveThree, 16, 1);
        assert!((low - 1.5_f64.sqrt()).abs() < 0.03 && (high - 0.718_75_f64.sqrt()).abs() < 0.03);
    }
}
