//! The error of gradients, which light and shade show before colours do.

use super::metric::{Metric, Subject};
use super::slab::Slab;
use crate::metrics::{Better, Figure};

/// Squares of central differences along each axis. A difference of errors is the error of a difference.
pub(super) struct Gradient;

/// Sum of squares along each axis, and of how many voxels.
pub(super) type Squares = [(f64, u64); 3];

impl Metric for Gradient {
    const FIGURES: &'static [Figure] = &[Figure {
        name: "gradient_error",
        heading: "gradient error",
        axis: "RMSE of the gradient, data units per voxel",
        unit: "data units per voxel",
        better: Better::Lower,
        definition: "root of the sum over the axes of mean(((e(p + 1) − e(p − 1)) ÷ 2)²), over voxels that have both \
                     neighbours; the length of a gradient's error, with no regard to spacing",
    }];
    type Sums = Squares;
    type Outcome = Option<f64>;

    fn new(_: &Subject<'_>) -> Self {
        Self
    }

    fn slab(&self, slab: &Slab<'_>) -> Squares {
        std::array::from_fn(|axis| {
            let (mut squares, mut voxels) = (0.0, 0);
            for (before, after) in slab.around(axis) {
                let run: f64 = before.iter().zip(after).map(|(a, b)| (b - a) * (b - a)).sum();
                squares += run;
                voxels += before.len() as u64;
            }
            (squares, voxels)
        })
    }

    fn add(&self, sums: &mut Squares, next: Squares) {
        for (sum, next) in sums.iter_mut().zip(next) {
            sum.0 += next.0;
            sum.1 += next.1;
        }
    }

    fn finish(&self, _: &Subject<'_>, sums: Squares) -> Option<f64> {
        let axes = || sums.iter().filter(|(_, voxels)| *voxels > 0);
        let squared: f64 = axes().map(|(squares, voxels)| squares / 4.0 / *voxels as f64).sum();
        // Infinite errors on both sides leave no number.
        let length = if squared.is_nan() { f64::INFINITY } else { squared.sqrt() };
        axes().next().map(|_| length)
    }

    fn values(outcome: &Option<f64>) -> Vec<Option<f64>> {
        vec![*outcome]
    }
}

#[cfg(test)]
mod tests {
    use crate::metrics::volume::tests::{error_of, error_of_channels};

    fn of(extent: [u32; 3], errors: &[f32]) -> Option<f64> {
        error_of(extent, errors, None).value("gradient_error")
    }

    #[test]
    fn a_ramp_of_errors_has_its_slope_along_each_axis() {
        let ramp = |slope: [f32; 3]| -> Vec<f32> {
            let at = |i: usize| [i % 3, i / 3 % 4, i / 12].map(|n| n as f32);
            (0..3 * 4 * 9).map(|i| at(i).iter().zip(slope).map(|(p, s)| p * s).sum()).collect()
        };
        for (slope, expected) in
            [([2.0, 0.0, 0.0], 2.0), ([0.0, 3.0, 0.0], 3.0), ([0.0, 0.0, 5.0], 5.0), ([2.0, 3.0, 6.0], 7.0)]
        {
            assert_eq!(of([3, 4, 9], &ramp(slope)), Some(expected), "{slope:?}");
        }
        // One voxel off by 2 at the end of a row of four: of two inner voxels one has a slope of 1.
        assert_eq!(of([4, 1, 1], &[0.0, 0.0, 0.0, 2.0]), Some(0.5_f64.sqrt()));
    }

    #[test]
    fn a_constant_error_has_none_and_thin_volumes_have_no_gradient() {
        assert_eq!(of([3, 3, 3], &[4.0; 27]), Some(0.0));
        assert_eq!(of([2, 2, 2], &[4.0; 8]), None);
        assert_eq!(of([2, 2, 3], &[4.0; 12]), Some(0.0));
        assert_eq!(of([3, 1, 1], &[f32::NAN, 0.0, f32::NAN]), Some(f64::INFINITY));
        // Channels: green rises by 1 per voxel, a third of all differences.
        let green: Vec<f32> = (0..9).map(|i| if i % 3 == 1 { (i / 3) as f32 } else { 0.0 }).collect();
        let error = error_of_channels([3, 1, 1], &green).value("gradient_error").unwrap();
        assert!((error - (1.0_f64 / 3.0).sqrt()).abs() < 1e-15);
    }
}
