//! How alike the errors of neighbouring voxels are: structure that an eye sees, where noise of the same size hides.

use super::metric::{Metric, Subject};
use super::slab::Slab;
use crate::metrics::{Better, Figure};

/// If the variance is below this fraction of the mean square, it is only rounding of a constant error.
const CONSTANT: f64 = 1e-12;

/// Moments of errors, and of neighbours along each axis.
pub(super) struct Autocorrelation;

/// Sums over all samples, and over the pairs of each axis.
#[derive(Copy, Clone, Debug, Default)]
pub(super) struct Moments {
    sum: f64,
    squares: f64,
    axes: [Pairs; 3],
}

/// Sums over pairs of neighbours: both errors, their product, and how many there are.
#[derive(Copy, Clone, Debug, Default)]
struct Pairs {
    both: f64,
    product: f64,
    pairs: u64,
}

impl Metric for Autocorrelation {
    const FIGURES: &'static [Figure] = &[Figure {
        name: "error_autocorrelation",
        heading: "error autocorrelation",
        axis: "autocorrelation of the error at one voxel",
        unit: "1",
        better: Better::Near("0"),
        definition: "mean over the axes of mean((e(p) − m)(e(q) − m)) ÷ mean((e − m)²) over neighbours p and q of one \
                     channel, with m the mean of e; empty where e is constant",
    }];
    type Sums = Moments;
    type Outcome = Option<f64>;

    fn new(_: &Subject<'_>) -> Self {
        Self
    }

    fn slab(&self, slab: &Slab<'_>) -> Moments {
        let mut moments = Moments::default();
        for e in slab.errors() {
            moments.sum += e;
            moments.squares += e * e;
        }
        for (axis, sums) in moments.axes.iter_mut().enumerate() {
            for (_, first, second) in slab.neighbours(axis) {
                let (mut both, mut product) = (0.0, 0.0);
                for (a, b) in first.iter().zip(second) {
                    both += a + b;
                    product += a * b;
                }
                sums.both += both;
                sums.product += product;
                sums.pairs += first.len() as u64;
            }
        }
        moments
    }

    fn add(&self, moments: &mut Moments, next: Moments) {
        moments.sum += next.sum;
        moments.squares += next.squares;
        for (axis, next) in moments.axes.iter_mut().zip(next.axes) {
            axis.both += next.both;
            axis.product += next.product;
            axis.pairs += next.pairs;
        }
    }

    fn finish(&self, subject: &Subject<'_>, moments: Moments) -> Option<f64> {
        let samples = subject.layout().samples() as f64;
        let (mean, square) = (moments.sum / samples, moments.squares / samples);
        let variance = square - mean * mean;
        if !variance.is_finite() || variance <= CONSTANT * square {
            return None;
        }
        let axes: Vec<f64> = moments
            .axes
            .iter()
            .filter(|axis| axis.pairs > 0)
            .map(|axis| {
                let pairs = axis.pairs as f64;
                (axis.product / pairs - mean * axis.both / pairs + mean * mean) / variance
            })
            .collect();
        (!axes.is_empty()).then(|| axes.iter().sum::<f64>() / axes.len() as f64)
    }

    fn values(outcome: &Option<f64>) -> Vec<Option<f64>> {
        vec![*outcome]
    }
}

#[cfg(test)]
mod tests {
    use crate::metrics::volume::tests::{error_of, error_of_channels};

    fn of(extent: [u32; 3], errors: &[f32]) -> Option<f64> {
        error_of(extent, errors, None).value("error_autocorrelation")
    }

    #[test]
    fn neighbours_that_alternate_are_opposed_and_those_that_agree_are_alike() {
        // Mean 0, variance 1; along x every product is −1, along y and z every one is 1.
        let stripes: Vec<f32> = (0..64).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        assert_eq!(of([4, 4, 4], &stripes), Some((-1.0 + 1.0 + 1.0) / 3.0));
        assert_eq!(of([64, 1, 1], &stripes), Some(-1.0));
        let halves: Vec<f32> = (0..64).map(|i| if i < 32 { 1.0 } else { -1.0 }).collect();
        assert_eq!(of([64, 1, 1], &halves), Some((62.0 - 1.0) / 63.0));
        // Across slabs of slices too: the sign turns between the fourth and the fifth of eight.
        let slices: Vec<f32> = (0..8).map(|z| if z < 4 { 1.0 } else { -1.0 }).collect();
        assert_eq!(of([1, 1, 8], &slices), Some((6.0 - 1.0) / 7.0));
    }

    #[test]
    fn the_mean_is_taken_off_and_a_constant_error_has_none() {
        // Errors 3 and 5: mean 4, deviations ∓1.
        let stripes: Vec<f32> = (0..64).map(|i| if i % 2 == 0 { 3.0 } else { 5.0 }).collect();
        assert_eq!(of([64, 1, 1], &stripes), Some(-1.0));
        assert_eq!(of([4, 4, 4], &[0.0; 64]), None);
        assert_eq!(of([4, 4, 4], &[0.1; 64]), None);
        assert_eq!(of([1, 1, 1], &[0.1]), None);
        assert_eq!(of([2, 1, 1], &[f32::NAN, 0.1]), None);
    }

    #[test]
    fn channels_do_not_mix() {
        // Red alternates along x, green and blue are right.
        let errors: Vec<f32> =
            (0..12).map(|i| if i % 3 == 0 { 1.0 - 2.0 * ((i / 3) % 2) as f32 } else { 0.0 }).collect();
        let error = error_of_channels([4, 1, 1], &errors);
        assert_eq!(error.value("error_autocorrelation"), Some((-3.0 / 9.0) / (4.0 / 12.0)));
    }
}
