//! The list of metrics of pictures.

use super::flip::Flip;
use super::metric::{Metric, Pair, Per};
use super::ms_ssim::MsSsim;
use super::psnr::Psnr;
use super::ssim::Ssim;
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
        /// Sums of the metrics over the pixels of pictures.
        #[derive(Copy, Clone, Debug, Default, PartialEq)]
        pub(super) struct Sums {
            $(pub(super) $name: <$metric as Metric>::Sums,)*
        }

        impl Sums {
            pub(super) fn compare(pair: &Pair<'_>) -> Self {
                Self { $($name: <$metric>::compare(pair),)* }
            }

            pub(super) fn add(&mut self, next: Self) {
                $(<$metric>::add(&mut self.$name, next.$name);)*
            }

            /// Names and values: per visible pixel of the reference, and per pixel of the whole picture. `None` if
            /// nothing is visible.
            pub(super) fn values(
                &self,
                against: Against,
                visible: u64,
                pixels: u64,
            ) -> impl Iterator<Item = (&'static str, Option<f64>)> {
                let pers = [Per::Visible(visible as f64), Per::Whole(pixels as f64)];
                let values = [$({
                    let [shown, whole, raw] = <$metric as Metric>::FIGURES.map(|figure| figure.name);
                    let [per_shown, per_whole] = pers.map(|per| match visible {
                        0 => None,
                        _ => <$metric>::value(&self.$name, per),
                    });
                    match against {
                        Against::Reference => [Some((shown, per_shown)), Some((whole, per_whole))],
                        Against::Raw => [Some((raw, per_shown)), None],
                    }
                },)*];
                values.into_iter().flatten().flatten()
            }
        }

        /// Figures of each metric.
        const FIGURES_OF: &[&[Figure]] = &[$(&<$metric as Metric>::FIGURES,)*];
    };
}

metrics! {
    psnr: Psnr,
    ssim: Ssim,
    ms_ssim: MsSsim,
    flip: Flip,
}

/// Every figure of pictures.
pub fn figures() -> impl Iterator<Item = &'static Figure> {
    FIGURES_OF.iter().copied().flatten()
}
