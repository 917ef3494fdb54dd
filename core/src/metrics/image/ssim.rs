//! SSIM of pictures, by the windows of `structure.rs`: one around every pixel.
//!
//! Where a window leaves the picture, the picture is mirrored at its border (the pixels of the border come twice). The
//! figure of the whole frame leaves such windows out, as Wang et al. 2004 and scikit-image do; tests compare it with
//! scikit-image. The figure per visible pixel has all windows, because visible pixels may lie at the border. Each wrong
//! pixel then counts in equally many windows.

use super::metric::{Metric, Pair, Per};
use super::structure::{Index, WINDOW, Windows, luma};
use crate::metrics::{Better, Figure};

/// The metric.
pub(super) struct Ssim;

/// Sums of 1 − s.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub(super) struct Dissimilarity {
    /// Over all pixels.
    all: f64,
    /// Over the pixels whose window lies in the picture.
    inner: f64,
    /// How many those are.
    windows: u64,
}

const fn ssim(
    name: &'static str,
    heading: &'static str,
    axis: &'static str,
    definition: &'static str,
) -> Figure {
    Figure { name, heading, axis, unit: "1", better: Better::Higher, definition }
}

impl Metric for Ssim {
    const FIGURES: [Figure; 3] = [
        ssim(
            "image_ssim",
            "picture SSIM",
            "SSIM of the picture",
            "1 − Σ(1 − s) ÷ visible pixels, with the s of `image_ssim_whole` of every pixel, the picture mirrored at its border",
        ),
        ssim(
            "image_ssim_whole",
            "whole-frame SSIM",
            "SSIM of the whole frame",
            "mean of the SSIM s over the pixels whose window lies in the picture: Wang et al. 2004, on luma; empty below 11 pixels",
        ),
        ssim(
            "codec_image_ssim",
            "codec's picture SSIM",
            "SSIM of the picture against raw",
            "`image_ssim` against raw's picture under the same site and filter",
        ),
    ];
    type Sums = Dissimilarity;

    fn compare(pair: &Pair<'_>) -> Dissimilarity {
        let mut sums = Dissimilarity::default();
        if pair.reference.is_empty() {
            return sums; // nothing to mirror
        }
        let reach = WINDOW / 2;
        let [a, b] = [pair.reference, pair.image].map(|rgb| luma(rgb, pair.size).mirrored(reach));
        let Windows { size: [width, height], values } = Windows::of(&a, &b);
        let inside = |at: usize, n: usize| at >= reach && at + reach < n;
        for (y, row) in values.chunks_exact(width).enumerate() {
            for (x, s) in row.iter().map(Index::similarity).enumerate() {
                sums.all += 1.0 - s;
                if inside(x, width) && inside(y, height) {
                    sums.inner += 1.0 - s;
                    sums.windows += 1;
                }
            }
        }
        sums
    }

    fn add(sums: &mut Dissimilarity, next: Dissimilarity) {
        sums.all += next.all;
        sums.inner += next.inner;
        sums.windows += next.windows;
    }

    fn value(sums: &Dissimilarity, per: Per) -> Option<f64> {
        match per {
            Per::Visible(pixels) => Some(1.0 - sums.all / pixels),
            Per::Whole(_) => (sums.windows > 0).then(|| 1.0 - sums.inner / sums.windows as f64),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::ImageError;
    use crate::metrics::image::tests::{assert_agrees, painted, whole};
    use crate::render::Image;

    const BLACK: [f32; 3] = [0.0; 3];

    /// Numbers of `tests/picture_ssim.py`, from scikit-image.
    #[test]
    fn agrees_with_scikit_image() {
        assert_agrees::<Ssim>(
            &[([192, 180], 0.722_248), ([100, 90], 0.713_208), ([31, 11], 0.715_000)],
            1e-6,
        );
    }

    /// Numbers of `tests/picture_ssim.py`, from scikit-image's full map, and of the picture below 11 pixels from SciPy's
    /// filter: what is visible touches three borders, and two columns are drawn where nothing should be.
    #[test]
    fn what_is_visible_may_lie_at_the_border() {
        let left = |image: &Image, more: u32| {
            let size @ [width, _] = image.size();
            let shows = |i: usize| 5 * (i as u32 % width) < 3 * width + more;
            let pixels = image.pixels().iter().enumerate();
            let pixels = pixels.map(|(i, p)| if shows(i) { *p } else { [0.0; 4] }).collect();
            Image::from_pixels(size, pixels).unwrap()
        };
        let expected =
            [([192, 180], 0.652_768), ([100, 90], 0.581_204), ([31, 11], 0.337_576), ([7, 5], -0.219_046)];
        for (size, expected) in expected {
            let [a, b] = painted(size);
            let (a, b) = (left(&a, 0), left(&b, 10));
            let error = ImageError::compare(&a, &b, BLACK).unwrap();
            let own = error.ssim().unwrap();
            assert!((own - expected).abs() < 1e-6, "{size:?}: {own} for {expected}");
            let fewer = ImageError::compare(&a, &left(&b, 0), BLACK).unwrap().ssim().unwrap();
            assert!(fewer > own + 1e-3, "{size:?}: what is drawn on nothing counts: {own}, {fewer} without");
        }
    }

    #[test]
    fn small_pictures_have_no_figure_of_the_whole_frame() {
        for (size, defined) in [([10, 40], false), ([40, 10], false), ([11, 11], true), ([1, 1], false)] {
            let [a, b] = painted(size);
            assert_eq!(whole::<Ssim>(&a, &b).is_some(), defined, "{size:?}");
            let error = ImageError::compare(&a, &b, BLACK).unwrap();
            assert!(error.ssim().unwrap() < 1.0, "{size:?}");
            assert_eq!(ImageError::compare(&a, &a, BLACK).unwrap().ssim(), Some(1.0));
        }
    }

    /// By hand: constant pictures of 0.5 and 0.25 have no contrast, so that luminance alone counts. A value that is not a number is
    /// not alike at all.
    #[test]
    fn constant_pictures_differ_in_luminance_alone() {
        let of = |tone: f32| Image::from_pixels([16, 16], vec![[tone, tone, tone, 1.0]; 256]).unwrap();
        let expected = (2.0 * 0.5 * 0.25 + 0.0001) / (0.25 + 0.0625 + 0.0001);
        let own = whole::<Ssim>(&of(0.5), &of(0.25)).unwrap();
        assert!((own - expected).abs() < 1e-9, "{own} for {expected}");
        assert_eq!(whole::<Ssim>(&of(0.5), &of(f32::NAN)), Some(0.0));
    }
}
