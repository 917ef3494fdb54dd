//! Error of a picture against a reference picture.
//!
//! Both are composited over the same opaque background. Error is summed over *all* pixels and divided by the
//! number of the reference's *visible* pixels: stray noise in the background counts, and cannot buy a larger
//! denominator. Whole-frame values, which divide by all pixels, stand beside.
//! One file holds one metric, and `list.rs` names them all.

mod flip;
mod gaussian;
mod list;
mod metric;
mod ms_ssim;
mod psnr;
mod ssim;
#[cfg(test)]
mod tests;

use self::list::Sums;
use self::metric::Pair;
use super::psnr_db;
use crate::render::Image;

pub use list::{Against, figures};

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
#[derive(Copy, Clone, Debug, Default, PartialEq)]
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
    /// Pixels, of several pictures together.
    pixels: u64,
    /// Pixels that errors are divided by: the visible ones, and at least one of each picture.
    shown: u64,
    sums: Sums,
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
        let squared = psnr::squared(&a, &b);
        let dissimilarity = ssim::dissimilarity(reference.size(), &a, &b);
        Ok(Self {
            psnr_db: psnr_db(squared / (3.0 * shown), 1.0),
            ssim: 1.0 - dissimilarity / shown,
            psnr_whole_db: psnr_db(squared / (3.0 * pixels), 1.0),
            ssim_whole: 1.0 - dissimilarity / pixels,
            visible_pixels: visible_pixels as u64,
            pixels: a.len() as u64,
            shown: visible_pixels.max(1) as u64,
            sums: Sums::compare(&Pair {
                size: reference.size().map(|n| n as usize),
                reference: &a,
                image: &b,
            }),
        })
    }

    /// Columns and values of the further metrics, by what the picture was compared with.
    pub fn values(&self, against: Against) -> impl Iterator<Item = (&'static str, Option<f64>)> {
        self.sums.values(against, self.shown as f64, self.pixels as f64)
    }
}

impl ImageError {
    /// Several pictures of one size as if they were one: errors are summed over the pixels of all.
    #[must_use]
    pub fn pooled(errors: impl Iterator<Item = Self>) -> Self {
        let (mut visible_pixels, mut pictures) = (0, 0.0);
        let (mut shown, mut squared, mut dissimilarity) = (0.0, 0.0, 0.0);
        let (mut squared_whole, mut dissimilarity_whole) = (0.0, 0.0);
        let (mut pixels, mut counted, mut sums) = (0, 0, Sums::default());
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
            pixels += error.pixels;
            counted += error.shown;
            sums.add(error.sums);
        }
        Self {
            psnr_db: psnr_db(squared / shown, 1.0),
            ssim: 1.0 - dissimilarity / shown,
            psnr_whole_db: psnr_db(squared_whole / pictures, 1.0),
            ssim_whole: 1.0 - dissimilarity_whole / pictures,
            visible_pixels,
            pixels,
            shown: counted,
            sums,
        }
    }
}
