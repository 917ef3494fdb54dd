//! SSIM of pictures: that of the crate `image-compare` 0.5 (`MSSIMSimple`) on 8-bit luma (ITU-R BT.601 weights).
//!
//! What it computes differs from the sliding Gaussian window of Wang et al. 2004: tiles of 8×8 pixels that do not overlap
//! (cut at the right and lower edge), uniform weights, and variances and covariance as *sums* over a tile, so that
//! `C2 = (0.03 · 255)²` weighs 1/64 of what it does in that paper and flat areas are judged more strictly. Its
//! numbers compare with each other and not with those of other programs. A tile's value stands for each of its
//! pixels, so a tile at the border of the object counts with all 64 of them.

use image_compare::{Algorithm, gray_similarity_structure, prelude::GrayImage};

use crate::metrics::{Better, Figure};

const fn ssim(
    name: &'static str,
    heading: &'static str,
    axis: &'static str,
    definition: &'static str,
) -> Figure {
    Figure { name, heading, axis, unit: "1", better: Better::Higher, definition }
}

/// The figures of this metric.
pub(super) const FIGURES: &[Figure] = &[
    ssim(
        "image_ssim",
        "picture SSIM",
        "SSIM of the picture",
        "1 − Σ(1 − s) ÷ visible pixels, with the SSIM s of the crate `image-compare` (tiles of 8×8 pixels of 8-bit luma)",
    ),
    ssim("image_ssim_whole", "whole-frame SSIM", "SSIM of the whole frame", "mean of that s over all pixels"),
    ssim(
        "codec_image_ssim",
        "codec's picture SSIM",
        "SSIM of the picture against raw",
        "`image_ssim` against raw's picture under the same site and filter",
    ),
];

/// `Σ(1 − s)` over all pixels.
pub(super) fn dissimilarity([width, height]: [u32; 2], a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    if a.is_empty() {
        return 0.0; // the crate's window needs a pixel
    }
    let luma = |p: &[f32; 3]| (255.0 * (0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2])).round() as u8;
    let grey = |pixels: &[[f32; 3]]| GrayImage::from_raw(width, height, pixels.iter().map(luma).collect());
    let similarity = grey(a).zip(grey(b)).and_then(|(a, b)| {
        gray_similarity_structure(&Algorithm::MSSIMSimple, &a, &b).ok() // errs on different sizes only
    });
    // The score is the mean over pixels, since tiles weigh by their area; the crate adds tiles up in their order.
    similarity.map_or(f64::NAN, |s| (1.0 - s.score) * a.len() as f64)
}
