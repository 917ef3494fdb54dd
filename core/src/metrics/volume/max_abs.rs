//! The largest error of a sample.

use super::metric::{Metric, Subject};
use super::slab::Slab;
use crate::metrics::{Better, Figure};

/// Largest absolute error.
pub(super) struct MaxAbs;

impl Metric for MaxAbs {
    const FIGURES: &'static [Figure] = &[Figure {
        name: "max_abs_error",
        heading: "max error",
        axis: "largest error of a voxel, data units",
        unit: "data units",
        better: Better::Lower,
        definition: "largest abs(e) of a sample",
    }];
    type Sums = f64;
    type Outcome = f64;

    fn new(_: &Subject<'_>) -> Self {
        Self
    }

    fn slab(&self, slab: &Slab<'_>) -> f64 {
        slab.errors().iter().fold(0.0, |max, e| e.abs().max(max))
    }

    fn add(&self, max: &mut f64, next: f64) {
        *max = max.max(next);
    }

    fn finish(&self, _: &Subject<'_>, max: f64) -> f64 {
        max
    }

    fn values(outcome: &f64) -> Vec<Option<f64>> {
        vec![Some(*outcome)]
    }
}
