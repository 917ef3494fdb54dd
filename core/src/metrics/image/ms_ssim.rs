//! MS-SSIM: structural similarity on several scales.
//!
//! After Z. Wang, E. P. Simoncelli and A. C. Bovik, "Multiscale structural similarity for image quality assessment",
//! Asilomar 2003, equations 1 to 7: the windows of `structure.rs` that lie wholly in the picture, and the exponents of
//! section 3.2.
//! Each scale halves the one before by means of 2×2 pixels; an odd last row or column is its own neighbour. As in the
//! authors' program, luminance enters at the coarsest scale as the mean of the whole index there, and a mean below zero
//! counts as zero.
//!
//! A scale is used as long as its shorter side has 11 pixels: all five from 161 pixels on. Below, the exponents of those
//! that are left are divided by their sum; a picture with a side below 11 pixels has no MS-SSIM.

use super::gaussian::Plane;
use super::metric::{Metric, Pair, Per};
use super::structure::{Index, WINDOW, Windows, luma};
use crate::metrics::{Better, Figure};

/// Exponents of the scales, the finest first.
const EXPONENTS: [f64; 5] = [0.0448, 0.2856, 0.3001, 0.2363, 0.1333];
/// The metric.
pub(super) struct MsSsim;

/// `Σ(1 − s)` over the pixels of a picture for the scales that are used, where `s` is the mean of a scale.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub(super) struct Dissimilarity {
    sums: [f64; EXPONENTS.len()],
    scales: usize,
}

const fn figure(
    name: &'static str,
    heading: &'static str,
    axis: &'static str,
    definition: &'static str,
) -> Figure {
    Figure { name, heading, axis, unit: "1", better: Better::Higher, definition }
}

impl Metric for MsSsim {
    const FIGURES: [Figure; 3] = [
        figure(
            "image_ms_ssim",
            "picture MS-SSIM",
            "MS-SSIM of the picture",
            "product of max(0, 1 − (1 − sⱼ) · pixels ÷ visible pixels)^wⱼ over the scales j of `image_ms_ssim_whole`",
        ),
        figure(
            "image_ms_ssim_whole",
            "whole-frame MS-SSIM",
            "MS-SSIM of the whole frame",
            "product of sⱼ^wⱼ over up to 5 scales j: Wang, Simoncelli and Bovik 2003, on luma; empty below 11 pixels",
        ),
        figure(
            "codec_image_ms_ssim",
            "codec's picture MS-SSIM",
            "MS-SSIM of the picture against raw",
            "`image_ms_ssim` against raw's picture under the same site and filter",
        ),
    ];
    type Sums = Dissimilarity;

    fn compare(pair: &Pair<'_>) -> Dissimilarity {
        let pixels = pair.reference.len() as f64;
        let (mut a, mut b) = (luma(pair.reference, pair.size), luma(pair.image, pair.size));
        let mut dissimilarity = Dissimilarity { scales: scales(pair.size), ..Dissimilarity::default() };
        for scale in 0..dissimilarity.scales {
            if scale > 0 {
                (a, b) = (halved(&a), halved(&b));
            }
            let coarsest = scale + 1 == dissimilarity.scales;
            dissimilarity.sums[scale] = (1.0 - similarity(&a, &b, coarsest)) * pixels;
        }
        dissimilarity
    }

    fn add(sums: &mut Dissimilarity, next: Dissimilarity) {
        sums.sums.iter_mut().zip(next.sums).for_each(|(sum, next)| *sum += next);
        sums.scales = next.scales;
    }

    fn value(sums: &Dissimilarity, per: Per) -> Option<f64> {
        let exponents = &EXPONENTS[..sums.scales];
        let total: f64 = exponents.iter().sum();
        let scales = sums.sums.iter().zip(exponents);
        let product = scales.map(|(sum, w)| (1.0 - sum / per.pixels()).max(0.0).powf(w / total)).product();
        (sums.scales > 0).then_some(product)
    }
}

/// Scales whose shorter side holds the window.
fn scales(size: [usize; 2]) -> usize {
    let shorter = size[0].min(size[1]);
    (0..EXPONENTS.len()).filter(|&scale| shorter.div_ceil(1 << scale) >= WINDOW).count()
}

/// Mean of contrast and structure, at the coarsest scale times luminance, over all windows.
fn similarity(a: &Plane, b: &Plane, with_luminance: bool) -> f64 {
    let of = if with_luminance { Index::similarity } else { Index::structure };
    let Windows { values, .. } = Windows::of(a, b);
    values.iter().map(of).sum::<f64>() / values.len() as f64
}

/// Means of 2×2 pixels.
fn halved(plane: &Plane) -> Plane {
    let [width, height] = plane.size;
    let size = [width.div_ceil(2), height.div_ceil(2)];
    let at = |x: usize, y: usize| plane.values[y.min(height - 1) * width + x.min(width - 1)];
    let places = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (2 * x, 2 * y)));
    let mean = |(x, y)| (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) / 4.0;
    Plane { size, values: places.map(mean).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::image::tests::{assert_agrees, painted, whole};

    /// Numbers of `tests/picture_metrics.py`, from TensorFlow.
    #[test]
    fn agrees_with_tensorflow() {
        // TensorFlow sums in single precision.
        assert_agrees::<MsSsim>(&MS_SSIM, 5e-5);
    }

    const MS_SSIM: [([u32; 2], f64); 4] =
        [([192, 180], 0.919_160), ([203, 161], 0.924_011), ([100, 90], 0.907_165), ([31, 11], 0.715_020)];

    #[test]
    fn small_pictures_have_fewer_scales() {
        let of = |side| scales([side, 500]);
        assert_eq!([10, 11, 20, 21, 40, 41, 80, 81, 160, 161].map(of), [0, 1, 1, 2, 2, 3, 3, 4, 4, 5]);
        let [a, b] = painted([10, 40]);
        assert_eq!(whole::<MsSsim>(&a, &b), None);
        let [a, b] = painted([11, 40]);
        assert_eq!(whole::<MsSsim>(&a, &a), Some(1.0));
        assert!(whole::<MsSsim>(&a, &b).unwrap() < 0.999);
    }

    /// By hand: constant pictures of 0.5 and 0.25 have no contrast, so that luminance alone counts, at the coarsest scale.
    #[test]
    fn constant_pictures_differ_in_luminance_alone() {
        let of = |tone: f32| {
            crate::render::Image::from_pixels([16, 16], vec![[tone, tone, tone, 1.0]; 256]).unwrap()
        };
        let expected = (2.0 * 0.5 * 0.25 + 0.0001) / (0.25 + 0.0625 + 0.0001);
        let own = whole::<MsSsim>(&of(0.5), &of(0.25)).unwrap();
        assert!((own - expected).abs() < 1e-9, "{own} for {expected}");
        assert_eq!(whole::<MsSsim>(&of(0.5), &of(f32::NAN)), Some(0.0));
    }
}
