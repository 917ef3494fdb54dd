//! What SSIM and MS-SSIM share: luma, and how alike two pictures are within a window.
//!
//! After Z. Wang, A. C. Bovik, H. R. Sheikh and E. P. Simoncelli, "Image quality assessment: from error visibility to
//! structural similarity", IEEE Trans. Image Processing 13 (4), 2004, section III.B: Gaussian windows of 11×11 pixels with
//! σ = 1.5, variances and covariance of the population they weigh, C1 = 0.01² and C2 = 0.03² for luma of full scale 1.

use super::gaussian::{Plane, gaussian};

/// Side of the window.
pub(super) const WINDOW: usize = 11;
/// Standard deviation of the window.
const SIGMA: f64 = 1.5;
/// Constants of luminance and of contrast and structure.
const C: [f64; 2] = [0.01 * 0.01, 0.03 * 0.03];

/// Luma by the weights of ITU-R BT.601, not rounded.
pub(super) fn luma(rgb: &[[f32; 3]], size: [usize; 2]) -> Plane {
    let luma = |p: &[f32; 3]| 0.299 * f64::from(p[0]) + 0.587 * f64::from(p[1]) + 0.114 * f64::from(p[2]);
    Plane { size, values: rgb.iter().map(luma).collect() }
}

/// How alike two pictures are within a window: 1 is equal. A value that is not a number is not alike at all.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Index {
    luminance: f64,
    structure: f64,
}

impl Index {
    /// Contrast and structure.
    pub(super) fn structure(&self) -> f64 {
        number(self.structure)
    }

    /// Luminance, contrast and structure: SSIM.
    pub(super) fn similarity(&self) -> f64 {
        number(self.structure * self.luminance)
    }
}

fn number(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value }
}

/// The indices of all windows that lie wholly in two planes of one size, in rows.
#[derive(Clone, Debug)]
pub(super) struct Windows {
    /// Windows along x and y: those of the plane less 10.
    pub(super) size: [usize; 2],
    /// Their indices.
    pub(super) values: Vec<Index>,
}

impl Windows {
    /// # Panics
    /// When a side of the planes is shorter than a window.
    pub(super) fn of(a: &Plane, b: &Plane) -> Self {
        let window = gaussian(SIGMA, WINDOW / 2);
        let mean = |plane: &Plane| plane.inner(&window, &window).values;
        let (means_a, means_b) = (mean(a), mean(b));
        let (aa, bb, ab) = (mean(&a.times(a)), mean(&b.times(b)), mean(&a.times(b)));
        let index = |i: usize| {
            let (x, y) = (means_a[i], means_b[i]);
            let (variances, covariance) = (aa[i] - x * x + bb[i] - y * y, ab[i] - x * y);
            Index {
                luminance: (2.0 * x * y + C[0]) / (x * x + y * y + C[0]),
                structure: (2.0 * covariance + C[1]) / (variances + C[1]),
            }
        };
        Self { size: a.size.map(|n| n + 1 - WINDOW), values: (0..ab.len()).map(index).collect() }
    }
}
