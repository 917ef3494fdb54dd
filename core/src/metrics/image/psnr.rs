//! Squared error and PSNR of pictures: three channels, peak 1.

use super::metric::{Metric, Pair, Per};
use crate::metrics::{Better, Figure, psnr_db};

/// The metric.
pub(super) struct Psnr;

const fn psnr(
    name: &'static str,
    heading: &'static str,
    axis: &'static str,
    definition: &'static str,
) -> Figure {
    Figure { name, heading, axis, unit: "dB", better: Better::Higher, definition }
}

impl Metric for Psnr {
    const FIGURES: [Figure; 3] = [
        psnr(
            "image_psnr_db",
            "picture PSNR, dB",
            "PSNR of the picture, dB",
            "−10 log₁₀(Σd² ÷ (3 · visible pixels)) over the differences d of red, green and blue, full scale 1",
        ),
        psnr(
            "image_psnr_whole_db",
            "whole-frame PSNR, dB",
            "PSNR of the whole frame, dB",
            "the same with all pixels in the denominator",
        ),
        psnr(
            "codec_image_psnr_db",
            "codec's picture PSNR, dB",
            "PSNR of the picture against raw, dB",
            "`image_psnr_db` against raw's picture under the same site and filter",
        ),
    ];
    /// Sum of squared differences over all channels; infinite where one is not a number.
    type Sums = f64;

    fn compare(pair: &Pair<'_>) -> f64 {
        let differences = pair.reference.iter().flatten().zip(pair.image.iter().flatten());
        differences
            .map(|(a, b)| f64::from(a - b))
            .map(|d| if d.is_nan() { f64::INFINITY } else { d * d })
            .sum()
    }

    fn add(sums: &mut f64, next: f64) {
        *sums += next;
    }

    fn value(squared: &f64, per: Per) -> Option<f64> {
        Some(psnr_db(squared / (3.0 * per.pixels()), 1.0))
    }
}
