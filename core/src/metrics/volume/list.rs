//! The list of metrics of voxels.

use super::autocorrelation::Autocorrelation;
use super::block_faces::BlockFaces;
use super::foreground::Foreground;
use super::gradient::Gradient;
use super::histogram::Histogram;
use super::max_abs::MaxAbs;
use super::mean_abs::MeanAbs;
use super::metric::{Metric, Subject};
use super::percentile::Percentile;
use super::slab::Slab;
use super::squared_error::Squared;
use crate::metrics::Figure;

/// Writes a struct of all metrics, one of their sums and one of their outcomes, each with a field per metric.
macro_rules! metrics {
    ($($name:ident: $metric:ty,)*) => {
        /// All metrics of voxels.
        pub(super) struct All {
            $($name: $metric,)*
        }

        /// Their sums.
        #[derive(Default)]
        pub(super) struct Sums {
            $(pub(super) $name: <$metric as Metric>::Sums,)*
        }

        /// The results.
        pub(super) struct Outcomes {
            $(pub(super) $name: <$metric as Metric>::Outcome,)*
        }

        /// Figures of each metric.
        const FIGURES_OF: &[&[Figure]] = &[$(<$metric as Metric>::FIGURES,)*];

        /// How many figures there are.
        pub(super) const COUNT: usize = 0 $(+ <$metric as Metric>::FIGURES.len())*;

        impl All {
            pub(super) fn new(subject: &Subject<'_>) -> Self {
                Self { $($name: <$metric>::new(subject),)* }
            }

            pub(super) fn slab(&self, slab: &Slab<'_>) -> Sums {
                Sums { $($name: self.$name.slab(slab),)* }
            }

            pub(super) fn add(&self, sums: &mut Sums, next: Sums) {
                $(self.$name.add(&mut sums.$name, next.$name);)*
            }

            pub(super) fn finish(&self, subject: &Subject<'_>, sums: Sums) -> Outcomes {
                Outcomes { $($name: self.$name.finish(subject, sums.$name),)* }
            }
        }

        impl Outcomes {
            /// The values of all figures, in their order.
            pub(super) fn values(&self) -> [Option<f64>; COUNT] {
                let mut values = [None; COUNT];
                let of_all = [$(<$metric>::values(&self.$name),)*].concat();
                values.iter_mut().zip(of_all).for_each(|(to, value)| *to = value);
                values
            }
        }
    };
}

metrics! {
    squared: Squared,
    foreground: Foreground,
    max_abs: MaxAbs,
    mean_abs: MeanAbs,
    percentile: Percentile,
    autocorrelation: Autocorrelation,
    gradient: Gradient,
    block_faces: BlockFaces,
    histogram: Histogram,
}

/// Every figure of voxels.
pub fn figures() -> impl Iterator<Item = &'static Figure> {
    FIGURES_OF.iter().copied().flatten()
}
