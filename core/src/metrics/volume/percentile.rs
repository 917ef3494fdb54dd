//! The 99.9th percentile of the error: exact, from the largest errors themselves.
//!
//! Only the ⌊n / 1000⌋ + 1 largest errors of `n` samples decide, so no more are kept. An error that a slab leaves out is never
//! one of them. The result therefore depends on neither slabs nor threads.

use super::metric::{Metric, Subject};
use super::slab::Slab;
use crate::metrics::{Better, Figure};

/// Bins of a first sieve: exponent and four bits of the mantissa of an error in single precision.
const BINS: usize = 1 << 12;

/// The largest errors.
pub(super) struct Percentile {
    /// How many of them decide.
    kept: usize,
}

impl Percentile {
    /// Leaves the largest errors alone.
    fn cut(&self, errors: &mut Vec<f64>) {
        if errors.len() > self.kept {
            errors.select_nth_unstable_by(self.kept - 1, |a, b| b.total_cmp(a));
            errors.truncate(self.kept);
        }
    }
}

impl Metric for Percentile {
    const FIGURES: &'static [Figure] = &[Figure {
        name: "p999_abs_error",
        heading: "99.9 % error",
        axis: "99.9th percentile of the error, data units",
        unit: "data units",
        better: Better::Lower,
        definition: "99.9th percentile of abs(e): the smallest value that at least 99.9 % of the samples do not exceed; exact",
    }];
    /// Errors other than zero.
    type Sums = Vec<f64>;
    type Outcome = f64;

    fn new(subject: &Subject<'_>) -> Self {
        Self { kept: subject.layout().samples() as usize / 1000 + 1 }
    }

    fn slab(&self, slab: &Slab<'_>) -> Vec<f64> {
        let errors = slab.errors();
        // Conversion to single precision keeps the order, so that a larger error is in no lower bin.
        let bin = |e: f64| ((e.abs() as f32).to_bits() >> 19) as usize;
        let mut bins = [0usize; BINS];
        errors.iter().for_each(|e| bins[bin(*e)] += 1);
        let mut above = 0;
        let lowest = (0..BINS).rev().find(|&b| {
            above += bins[b];
            above >= self.kept
        });
        let lowest = lowest.unwrap_or(0);
        let mut largest: Vec<f64> =
            errors.iter().filter(|e| **e != 0.0 && bin(**e) >= lowest).map(|e| e.abs()).collect();
        self.cut(&mut largest);
        largest
    }

    fn add(&self, largest: &mut Vec<f64>, next: Vec<f64>) {
        largest.extend(next);
        if largest.len() > 4 * self.kept {
            self.cut(largest);
        }
    }

    fn finish(&self, _: &Subject<'_>, mut largest: Vec<f64>) -> f64 {
        self.cut(&mut largest);
        // Errors that are missing are zero.
        if largest.len() < self.kept { 0.0 } else { largest.into_iter().fold(f64::INFINITY, f64::min) }
    }

    fn values(outcome: &f64) -> Vec<Option<f64>> {
        vec![Some(*outcome)]
    }
}

#[cfg(test)]
mod tests {
    use crate::metrics::volume::tests::error_of;

    /// Errors 1, 2 … 4000 in disorder, of both signs.
    fn shuffled() -> Vec<f32> {
        let sign = |i: u32| if i.is_multiple_of(3) { -1.0 } else { 1.0 };
        (0..4000u32).map(|i| sign(i) * ((i * 1777) % 4000 + 1) as f32).collect()
    }

    #[test]
    fn a_thousandth_of_the_samples_is_beyond_it() {
        let p999 = |errors: &[f32]| error_of([20, 20, 10], errors, None).value("p999_abs_error");
        let mut errors = shuffled();
        // 3997, 3998, 3999 and 4000 are the four of 4000 that may be beyond.
        assert_eq!(p999(&errors), Some(3996.0));
        // Whether those four are larger still does not matter; one more of them does.
        errors.iter_mut().filter(|e| e.abs() > 3996.0).for_each(|e| *e *= 100.0);
        assert_eq!(p999(&errors), Some(3996.0));
        let fifth = errors.iter().position(|e| e.abs() == 3996.0).unwrap();
        errors[fifth] = 3996.5;
        assert_eq!(p999(&errors), Some(3996.5));
    }

    #[test]
    fn few_errors_leave_it_at_zero_and_endless_ones_count() {
        let p999 = |errors: &[f32]| error_of([20, 20, 10], errors, None).value("p999_abs_error");
        let mut errors = vec![0.0; 4000];
        assert_eq!(p999(&errors), Some(0.0));
        errors[..4].fill(9.0);
        assert_eq!(p999(&errors), Some(0.0));
        errors[4] = f32::NAN;
        assert_eq!(p999(&errors), Some(9.0));
        errors[..5].fill(f32::NAN);
        assert_eq!(p999(&errors), Some(f64::INFINITY));
        // For a single sample, all percentiles are its error.
        assert_eq!(error_of([1, 1, 1], &[-3.0], None).value("p999_abs_error"), Some(3.0));
    }
}
