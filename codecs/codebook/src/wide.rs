//! Loops in the widest vector instructions that the processor has.
//!
//! The compiler turns loops over lanes into vector instructions. Their width does not change results: every lane is
//! rounded on its own, the source states the number of lanes of a sum, and the compiler fuses nothing by itself.

use pulp::Arch;

/// Lanes of a sum in double precision.
const LANES: usize = 8;

/// Runs `work`, compiled for this processor. Functions that it calls must be inlined to benefit.
#[inline]
pub fn wide<R>(work: impl FnOnce() -> R) -> R {
    Arch::new().dispatch(work)
}

/// `Σ a·b`.
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += a * b;
        }
    }
    lanes.iter().sum::<f64>() + rest
}

/// `Σ a·b` in single precision, in twice as many lanes.
#[inline(always)]
pub fn dot_single(a: &[f32], b: &[f32]) -> f32 {
    let mut lanes = [0.0; 2 * LANES];
    let (a, b) = (a.chunks_exact(2 * LANES), b.chunks_exact(2 * LANES));
    let rest: f32 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += a * b;
        }
    }
    lanes.iter().sum::<f32>() + rest
}

/// `sums += factor · terms`.
#[inline(always)]
pub fn add_scaled(sums: &mut [f64], factor: f64, terms: &[f64]) {
    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += factor * term);
}

/// `differences = vector − mean`.
#[inline(always)]
pub fn subtract(vector: &[f32], mean: &[f64], differences: &mut [f64]) {
    for (d, (x, m)) in differences.iter_mut().zip(vector.iter().zip(mean)) {
        *d = f64::from(*x) - m;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_hold_every_term_once() {
        for count in 0..40_usize {
            let a: Vec<f64> = (0..count).map(|i| (i * i) as f64).collect();
            let b: Vec<f64> = (0..count).map(|i| i as f64 - 3.0).collect();
            let expected: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
            assert_eq!(wide(|| dot(&a, &b)), expected, "{count} terms");
            let single = |v: &[f64]| v.iter().map(|x| *x as f32).collect::<Vec<_>>();
            assert_eq!(f64::from(wide(|| dot_single(&single(&a), &single(&b)))), expected, "{count} terms");
        }
    }
}
