//! Metrics of pictures that add up over pixels.

use crate::metrics::Figure;

/// Two pictures of one size over an opaque background, RGB `0.0..=1.0` in rows.
#[derive(Copy, Clone, Debug)]
pub(super) struct Pair<'a> {
    /// Width and height.
    pub(super) size: [usize; 2],
    /// What should be seen.
    pub(super) reference: &'a [[f32; 3]],
    /// The picture to judge.
    pub(super) image: &'a [[f32; 3]],
}

/// The pixels that sums are divided by.
#[derive(Copy, Clone, Debug)]
pub(super) enum Per {
    /// The visible pixels of the reference; at least one.
    Visible(f64),
    /// All pixels.
    Whole(f64),
}

impl Per {
    /// How many there are.
    pub(super) const fn pixels(self) -> f64 {
        match self {
            Self::Visible(pixels) | Self::Whole(pixels) => pixels,
        }
    }
}

/// Adds up over the pixels of one picture or several, and divides by the pixels that count.
pub(super) trait Metric {
    /// Per visible pixel against the reference, over the whole frame, and per visible pixel against raw's picture.
    const FIGURES: [Figure; 3];
    /// The sums.
    type Sums: Copy + Default + std::fmt::Debug + PartialEq;

    /// The sums of a picture.
    fn compare(pair: &Pair<'_>) -> Self::Sums;
    /// Adds the sums of another picture of the same size.
    fn add(sums: &mut Self::Sums, next: Self::Sums);
    /// The value when these pixels count; `None` where the metric has no meaning.
    fn value(sums: &Self::Sums, per: Per) -> Option<f64>;
}
