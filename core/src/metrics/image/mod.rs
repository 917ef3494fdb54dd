//! Error of a picture against a reference picture.
//!
//! Both are composited over the same opaque background. Error is summed over *all* pixels and divided by the
//! number of the reference's *visible* pixels: stray noise in the background counts, and does not enlarge the
//! denominator. Whole-frame values divide by all pixels. A reference that shows nothing cannot judge a picture: there is no
//! value then, not even of the whole frame.
//! One file holds one metric, and `list.rs` names them all.

mod flip;
mod gaussian;
mod list;
mod metric;
mod ms_ssim;
mod psnr;
mod ssim;
mod structure;
#[cfg(test)]
mod tests;

use self::list::Sums;
use self::metric::{Metric as _, Pair, Per};
use self::psnr::Psnr;
use self::ssim::Ssim;
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

/// Error of a picture, or of several together, against a reference. Every figure is `None` where the reference shows
/// nothing.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct ImageError {
    /// Visible pixels of the reference.
    pub visible_pixels: u64,
    /// All pixels.
    pixels: u64,
    sums: Sums,
}

impl ImageError {
    /// Compares two pictures over an opaque background.
    ///
    /// # Errors
    /// When the pictures differ in size.
    pub fn compare(reference: &Image, image: &Image, background: [f32; 3]) -> Result<Self, SizeMismatch> {
        SizeMismatch::check(reference, image)?;
        let (a, b) = (reference.over(background), image.over(background));
        let size = reference.size().map(|n| n as usize);
        Ok(Self {
            visible_pixels: reference.pixels().iter().filter(|p| visible(p)).count() as u64,
            pixels: a.len() as u64,
            sums: Sums::compare(&Pair { size, reference: &a, image: &b }),
        })
    }

    /// Several pictures of one size as if they were one: errors are summed over the pixels of all, and divided by the
    /// visible pixels of all.
    #[must_use]
    pub fn pooled(errors: impl Iterator<Item = Self>) -> Self {
        let mut pooled = Self::default();
        for Self { visible_pixels, pixels, sums } in errors {
            pooled.visible_pixels += visible_pixels;
            pooled.pixels += pixels;
            pooled.sums.add(sums);
        }
        pooled
    }

    /// Columns and values, by what the picture was compared with.
    pub fn values(&self, against: Against) -> impl Iterator<Item = (&'static str, Option<f64>)> {
        self.sums.values(against, self.visible_pixels, self.pixels)
    }

    /// PSNR per visible pixel of the reference in dB, three channels, peak 1; infinite without error.
    #[must_use]
    pub fn psnr_db(&self) -> Option<f64> {
        self.per_visible().and_then(|per| Psnr::value(&self.sums.psnr, per))
    }

    /// `1 − Σ(1 − s) / visible pixels` over the SSIM `s` of every pixel; it has no lower bound.
    #[must_use]
    pub fn ssim(&self) -> Option<f64> {
        self.per_visible().and_then(|per| Ssim::value(&self.sums.ssim, per))
    }

    /// Sum of the squared differences of red, green and blue over all pixels, full scale 1; also where the reference shows
    /// nothing.
    #[must_use]
    pub const fn squared_error(&self) -> f64 {
        self.sums.psnr
    }

    fn per_visible(&self) -> Option<Per> {
        (self.visible_pixels > 0).then_some(Per::Visible(self.visible_pixels as f64))
    }
}
