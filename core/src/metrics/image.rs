//! Error of a picture against a reference picture.
//!
//! Both are composited over the same opaque background. Error is summed over *all* pixels and divided by the
//! number of the reference's *visible* pixels: stray noise in the background counts, and cannot buy a larger
//! denominator. Whole-frame values, which divide by all pixels, stand beside.
//!
//! SSIM is that of the crate `image-compare` 0.5 (`MSSIMSimple`) on 8-bit luma (ITU-R BT.601 weights). What it
//! computes differs from the sliding Gaussian window of Wang et al. 2004: tiles of 8×8 pixels that do not overlap
//! (cut at the right and lower edge), uniform weights, and variances and covariance as *sums* over a tile, so that
//! `C2 = (0.03 · 255)²` weighs 1/64 of what it does in that paper and flat areas are judged more strictly. Its
//! numbers compare with each other and not with those of other programs. A tile's value stands for each of its
//! pixels, so a tile at the border of the object counts with all 64 of them.

use image_compare::{Algorithm, gray_similarity_structure, prelude::GrayImage};

use super::psnr_db;
use crate::render::Image;

/// A pixel is visible above this opacity: half a step of 8 bits, so that it does not round to nothing.
pub const VISIBLE_ALPHA: f32 = 1.0 / 510.0;

/// Whether a premultiplied pixel is visible.
#[must_use]
pub fn visible(pixel: &[f32; 4]) -> bool {
    pixel[3] > VISIBLE_ALPHA
}

/// Two pictures of different size cannot be compared.
#[derive(Copy, Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("pictures of {0}×{1} and {2}×{3} pixels cannot be compared")]
pub struct SizeMismatch(u32, u32, u32, u32);

impl SizeMismatch {
    pub(super) fn check(a: &Image, b: &Image) -> Result<(), Self> {
        let ([aw, ah], [bw, bh]) = (a.size(), b.size());
        if a.size() == b.size() { Ok(()) } else { Err(Self(aw, ah, bw, bh)) }
    }
}

/// Error of a picture against a reference.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ImageError {
    /// PSNR per visible pixel of the reference, three channels, peak 1; infinite without error.
    pub psnr_db: f64,
    /// `1 − Σ(1 − s) / visible pixels` over the SSIM `s` of every pixel; it has no lower bound.
    pub ssim: f64,
    /// PSNR over the whole frame.
    pub psnr_whole_db: f64,
    /// Mean SSIM over the whole frame.
    pub ssim_whole: f64,
    /// Visible pixels of the reference.
    pub visible_pixels: u64,
}

impl ImageError {
    /// Compares two pictures over an opaque background.
    ///
    /// A reference without any visible pixel counts as one pixel: two blank pictures are identical, and whatever
    /// is drawn where nothing should be counts in full.
    ///
    /// # Errors
    /// When the pictures differ in size.
    pub fn compare(reference: &Image, image: &Image, background: [f32; 3]) -> Result<Self, SizeMismatch> {
        SizeMismatch::check(reference, image)?;
        let (a, b) = (reference.over(background), image.over(background));
        let pixels = a.len().max(1) as f64;
        let visible_pixels = reference.pixels().iter().filter(|p| visible(p)).count();
        let shown = visible_pixels.max(1) as f64;
        // Pictures are small: one thread adds up faster than several start.
        let squared: f64 = a
            .iter()
            .flatten()
            .zip(b.iter().flatten())
            .map(|(a, b)| f64::from(a - b))
            .map(|d| if d.is_nan() { f64::INFINITY } else { d * d })
            .sum();
        let dissimilarity = dissimilarity(reference.size(), &a, &b);
        Ok(Self {
            psnr_db: psnr_db(squared / (3.0 * shown), 1.0),
            ssim: 1.0 - dissimilarity / shown,
            psnr_whole_db: psnr_db(squared / (3.0 * pixels), 1.0),
            ssim_whole: 1.0 - dissimilarity / pixels,
            visible_pixels: visible_pixels as u64,
        })
    }
}

impl ImageError {
    /// Several pictures of one size as if they were one: errors are summed over the pixels of all.
    #[must_use]
    pub fn pooled(errors: impl Iterator<Item = Self>) -> Self {
        let (mut visible_pixels, mut pictures) = (0, 0.0);
        let (mut shown, mut squared, mut dissimilarity) = (0.0, 0.0, 0.0);
        let (mut squared_whole, mut dissimilarity_whole) = (0.0, 0.0);
        let mse = |psnr_db: f64| 10.0_f64.powf(-psnr_db / 10.0);
        for error in errors {
            let weight = error.visible_pixels.max(1) as f64;
            visible_pixels += error.visible_pixels;
            shown += weight;
            squared += weight * mse(error.psnr_db);
            dissimilarity += weight * (1.0 - error.ssim);
            pictures += 1.0;
            squared_whole += mse(error.psnr_whole_db);
            dissimilarity_whole += 1.0 - error.ssim_whole;
        }
        Self {
            psnr_db: psnr_db(squared / shown, 1.0),
            ssim: 1.0 - dissimilarity / shown,
            psnr_whole_db: psnr_db(squared_whole / pictures, 1.0),
            ssim_whole: 1.0 - dissimilarity_whole / pictures,
            visible_pixels,
        }
    }
}

/// `Σ(1 − s)` over all pixels.
fn dissimilarity([width, height]: [u32; 2], a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::shifted;

    const BLACK: [f32; 3] = [0.0; 3];

    /// A disc with a pattern, on nothing.
    fn disc(size: u32) -> Image {
        let mut image = Image::new([size, size]);
        let centre = size as f32 / 2.0;
        for y in 0..size {
            for x in 0..size {
                let (u, v) = (x as f32 + 0.5 - centre, y as f32 + 0.5 - centre);
                if u.hypot(v) < centre * 0.5 {
                    let tone = 0.5 + 0.3 * (u * 0.9).sin() * (v * 0.7).cos();
                    image.pixels_mut()[(y * size + x) as usize] = [tone, tone * 0.8, 0.3, 1.0];
                }
            }
        }
        image
    }

    #[test]
    fn equal_pictures_are_identical_and_one_step_of_eight_bits_is_noticed() {
        let a = disc(40);
        let equal = ImageError::compare(&a, &a, BLACK).unwrap();
        assert_eq!((equal.psnr_db, equal.psnr_whole_db), (f64::INFINITY, f64::INFINITY));
        assert_eq!((equal.ssim, equal.ssim_whole), (1.0, 1.0));

        let mut b = a.clone();
        let middle = 20 * 40 + 20;
        (0..3).for_each(|c| b.pixels_mut()[middle][c] += 1.0 / 255.0);
        let off = ImageError::compare(&a, &b, BLACK).unwrap();
        assert!(off.psnr_db.is_finite() && off.ssim < 1.0, "{off:?}");
        // PSNR compares the floats themselves; SSIM, on 8 bits, cannot see one bit.
        b.pixels_mut()[middle] = a.pixels()[middle];
        b.pixels_mut()[middle][1] = f32::from_bits(a.pixels()[middle][1].to_bits() + 1);
        assert!(ImageError::compare(&a, &b, BLACK).unwrap().psnr_db.is_finite());
    }

    #[test]
    fn a_shift_of_one_pixel_costs_much() {
        let a = disc(64);
        let off = ImageError::compare(&a, &shifted(&a, 1, 0), BLACK).unwrap();
        assert!(off.psnr_db < 30.0 && off.ssim < 0.95, "{off:?}");
        assert!(off.psnr_whole_db > off.psnr_db && off.ssim_whole > off.ssim);
    }

    #[test]
    fn error_is_divided_by_the_visible_pixels_of_the_reference() {
        let mut a = Image::new([10, 10]);
        a.pixels_mut()[0] = [0.5, 0.5, 0.5, 1.0];
        a.pixels_mut()[1] = [0.001, 0.001, 0.001, 1.0 / 511.0]; // rounds to nothing
        let mut b = a.clone();
        b.pixels_mut()[99] = [0.1, 0.1, 0.1, 1.0]; // stray, where the reference shows nothing
        let error = ImageError::compare(&a, &b, BLACK).unwrap();
        assert_eq!(error.visible_pixels, 1);
        assert!((error.psnr_db - 20.0).abs() < 1e-5, "{error:?}");
        assert!((error.psnr_whole_db - 40.0).abs() < 1e-5, "{error:?}");
        // Drawing more does not help: only the reference's pixels count.
        let swapped = ImageError::compare(&b, &a, BLACK).unwrap();
        assert!(swapped.psnr_db > error.psnr_db);
    }

    #[test]
    fn blank_pictures_are_identical_and_drawing_on_nothing_is_an_error() {
        let blank = Image::new([8, 8]);
        let equal = ImageError::compare(&blank, &blank, [1.0; 3]).unwrap();
        assert_eq!((equal.psnr_db, equal.ssim, equal.visible_pixels), (f64::INFINITY, 1.0, 0));
        let mut drawn = blank.clone();
        drawn.pixels_mut()[3] = [0.0, 0.0, 0.0, 1.0];
        let error = ImageError::compare(&blank, &drawn, [1.0; 3]).unwrap();
        assert!(error.psnr_db.abs() < 1e-6 && error.ssim < 1.0, "{error:?}");
        assert!(ImageError::compare(&Image::new([0, 0]), &Image::new([0, 0]), BLACK).is_ok());
    }

    #[test]
    fn sizes_must_agree() {
        let error = ImageError::compare(&Image::new([2, 3]), &Image::new([3, 2]), BLACK).unwrap_err();
        assert_eq!(error.to_string(), "pictures of 2×3 and 3×2 pixels cannot be compared");
    }

    /// Two pictures side by side are one of twice the width, whose tiles of SSIM are the same.
    #[test]
    fn pooled_pictures_are_one_picture() {
        let (a, b) = (disc(32), shifted(&disc(32), 0, 3));
        let beside = |left: &Image, right: &Image| {
            let mut both = Image::new([64, 32]);
            for y in 0..32 {
                both.pixels_mut()[y * 64..y * 64 + 32].copy_from_slice(&left.pixels()[y * 32..(y + 1) * 32]);
                both.pixels_mut()[y * 64 + 32..(y + 1) * 64]
                    .copy_from_slice(&right.pixels()[y * 32..(y + 1) * 32]);
            }
            both
        };
        let empty = Image::new([32, 32]);
        for (second, other) in [(&b, &a), (&a, &a), (&empty, &a)] {
            let whole = ImageError::compare(&beside(&a, second), &beside(&b, other), BLACK).unwrap();
            let parts = [(&a, &b), (second, other)].map(|(a, b)| ImageError::compare(a, b, BLACK).unwrap());
            let pooled = ImageError::pooled(parts.into_iter());
            assert_eq!(pooled.visible_pixels, whole.visible_pixels);
            // A picture of nothing counts as one visible pixel.
            let tolerance = if second == &empty { 0.03 } else { 1e-9 };
            for (pooled, whole) in [
                (pooled.psnr_db, whole.psnr_db),
                (pooled.psnr_whole_db, whole.psnr_whole_db),
                (pooled.ssim, whole.ssim),
                (pooled.ssim_whole, whole.ssim_whole),
            ] {
                assert!((pooled - whole).abs() < tolerance, "{pooled} for {whole}");
            }
        }
    }
}
