//! The list of metrics of pictures.

use super::{psnr, ssim};
use crate::metrics::Figure;

/// Every figure of pictures.
pub fn figures() -> impl Iterator<Item = &'static Figure> {
    [psnr::FIGURES, ssim::FIGURES].into_iter().flatten()
}
