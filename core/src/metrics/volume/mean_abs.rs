//! The mean absolute error.

use super::metric::{Metric, Subject};
use super::slab::Slab;
use crate::metrics::{Better, Figure};

/// Sum of absolute errors.
pub(super) struct MeanAbs;

impl Metric for MeanAbs {
    const FIGURES: &'static [Figure] = &[Figure {
        name: "mean_abs_error",
        heading: "mean error",
        axis: "mean error of the voxels, data units",
        unit: "data units",
        better: Better::Lower,
        definition: "mean of abs(e) over all samples",
    }];
    type Sums = f64;
    type Outcome = f64;

    fn new(_: &Subject<'_>) -> Self {
        Self
    }

    fn slab(&self, slab: &Slab<'_>) -> f64 {
        slab.errors().iter().map(|e| e.abs()).sum()
    }

    fn add(&self, sum: &mut f64, next: f64) {
        *sum += next;
    }

    fn finish(&self, subject: &Subject<'_>, sum: f64) -> f64 {
        sum / subject.layout().samples() as f64
    }

    fn values(outcome: &f64) -> Vec<Option<f64>> {
        vec![Some(*outcome)]
    }
}

#[cfg(test)]
mod tests {
    use crate::metrics::volume::tests::error_of;

    #[test]
    fn is_the_mean_of_absolute_errors() {
        // (1 + 2 + 0 + 5) / 4; the mean of the errors themselves is another number.
        let error = error_of([4, 1, 1], &[1.0, -2.0, 0.0, 5.0], None);
        assert_eq!(error.value("mean_abs_error"), Some(2.0));
        let signed = error_of([4, 1, 1], &[1.0, -2.0, 0.0, 4.0], None);
        assert_ne!(signed.value("mean_abs_error"), Some(2.0));
        assert_eq!(error_of([4, 1, 1], &[0.0; 4], None).value("mean_abs_error"), Some(0.0));
        let endless = error_of([4, 1, 1], &[0.0, f32::NAN, 0.0, 0.0], None);
        assert_eq!(endless.value("mean_abs_error"), Some(f64::INFINITY));
    }
}
