//! Squared error and PSNR of pictures: three channels, peak 1.

use crate::metrics::{Better, Figure};

const fn psnr(
    name: &'static str,
    heading: &'static str,
    axis: &'static str,
    definition: &'static str,
) -> Figure {
    Figure { name, heading, axis, unit: "dB", better: Better::Higher, definition }
}

/// The figures of this metric.
pub(super) const FIGURES: &[Figure] = &[
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

/// Sum of squared differences over all channels; infinite where one is no number.
pub(super) fn squared(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    a.iter()
        .flatten()
        .zip(b.iter().flatten())
        .map(|(a, b)| f64::from(a - b))
        .map(|d| if d.is_nan() { f64::INFINITY } else { d * d })
        .sum()
}
