//! The list of metrics of pictures.

use super::flip::Flip;
use super::metric::{Metric, Pair};
use super::ms_ssim::MsSsim;
use super::{psnr, ssim};
use crate::metrics::Figure;

/// Which picture another is compared with.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Against {
    /// The reference: uncompressed, manual linear filter.
    Reference,
    /// Raw's picture under the same site and filter.
    Raw,
}

/// Writes a struct of the sums of all metrics, with a field per metric.
macro_rules! metrics {
    ($($name:ident: $metric:ty,)*) => {
        /// What the metrics that are not [`psnr`] and [`ssim`] add up over the pixels of pictures.
        #[derive(Copy, Clone, Debug, Default, PartialEq)]
        pub(super) struct Sums {
            $($name: <$metric as Metric>::Sums,)*
        }

        impl Sums {
            pub(super) fn compare(pair: &Pair<'_>) -> Self {
                Self { $($name: <$metric>::compare(pair),)* }
            }

            pub(super) fn add(&mut self, next: Self) {
                $(<$metric>::add(&mut self.$name, next.$name);)*
            }

            /// Names and values, of `shown` visible pixels and so many of the whole frame.
            pub(super) fn values(
                &self,
                against: Against,
                shown: f64,
                pixels: f64,
            ) -> impl Iterator<Item = (&'static str, Option<f64>)> {
                let values = [$({
                    let [visible, whole, raw] = <$metric as Metric>::FIGURES.map(|figure| figure.name);
                    let of = |pixels| <$metric>::value(&self.$name, pixels);
                    match against {
                        Against::Reference => [Some((visible, of(shown))), Some((whole, of(pixels)))],
                        Against::Raw => [Some((raw, of(shown))), None],
                    }
                },)*];
                values.into_iter().flatten().flatten()
            }
        }

        /// Figures of each metric.
        const FIGURES_OF: &[&[Figure]] = &[psnr::FIGURES, ssim::FIGURES, $(&<$metric as Metric>::FIGURES,)*];
    };
}

metrics! {
    ms_ssim: MsSsim,
    flip: Flip,
}

/// Every figure of pictures.
pub fn figures() -> impl Iterator<Item = &'static Figure> {
    FIGURES_OF.iter().copied().flatten()
}
