//! How far a decoded volume, or the picture drawn from it, is from the original.
//!
//! Pure functions. Sums are accumulated in double precision over fixed pieces in a fixed order, so that a result
//! does not depend on the number of threads.

mod agreement;
mod error_picture;
mod figure;
mod image;
mod list;
mod volume;

pub use agreement::{AgreementRule, Disagreement, ImageAgreement, image_agreement, shifted};
pub use error_picture::{ERROR_CLASSES, ErrorClass, error_colour, error_picture};
pub use figure::{Better, Figure};
pub use image::{Against, ImageError, SizeMismatch, VISIBLE_ALPHA, visible};
pub use volume::{ErrorBin, ErrorHistogram, FrameError, VolumeComparison, VolumeError, isosurface};

/// Every figure of a codec's error: of voxels first, then of pictures.
pub fn figures() -> impl Iterator<Item = &'static Figure> {
    volume::figures().chain(image::figures())
}

/// Peak signal-to-noise ratio in dB: `+∞` without error, `−∞` when the error is infinite.
///
/// A `peak` of zero (constant data) has no ratio of its own: 1 takes its place, so that an error still yields a
/// finite number in data units.
#[must_use]
pub fn psnr_db(mse: f64, peak: f64) -> f64 {
    let peak = if peak > 0.0 { peak } else { 1.0 };
    if mse == 0.0 { f64::INFINITY } else { 20.0 * peak.log10() - 10.0 * mse.log10() }
}

#[cfg(test)]
mod tests {
    use super::psnr_db;

    #[test]
    fn psnr_follows_its_definition_at_the_ends_too() {
        assert!((psnr_db(1.0, 255.0) - 48.130_803_608_679_1).abs() < 1e-9);
        assert_eq!(psnr_db(0.0, 255.0), f64::INFINITY);
        assert_eq!(psnr_db(0.0, 0.0), f64::INFINITY);
        assert_eq!(psnr_db(0.01, 0.0), 20.0);
        assert_eq!(psnr_db(f64::INFINITY, 1.0), f64::NEG_INFINITY);
    }
}
