//! The histogram of errors.
//!
//! At most 512 bins, `[k·w, (k + 1)·w)` for k from −256 to 255. The width `w` of integers is 1, so that each error up to
//! 255 has a bin of its own; of floats it is the largest power of two not above the range, over 2²⁴. It is doubled until
//! every finite error has a bin, which joins neighbours in pairs: what comes out depends on the largest errors alone
//! and not on the order in which they came.

use super::metric::{Metric, Subject};
use super::slab::Slab;
use crate::metrics::Figure;

/// Bins on each side of zero.
const SIDE: i64 = 256;

/// Counts errors.
pub(super) struct Histogram {
    /// Width of a bin before any doubling.
    finest: f64,
}

/// How many samples have which error, decoded − original in data units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorHistogram {
    finest: f64,
    /// How often the width was doubled.
    doublings: u32,
    /// 2 × [`SIDE`] bins, or none before anything is counted.
    bins: Vec<u64>,
    infinite: u64,
}

/// One bin.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ErrorBin {
    /// Lowest error.
    pub from: f64,
    /// First error that is too large.
    pub below: f64,
    /// Samples.
    pub samples: u64,
}

impl ErrorHistogram {
    /// The bins in rising order, from the first to the last that is not empty.
    pub fn bins(&self) -> impl Iterator<Item = ErrorBin> {
        let width = self.width();
        let first = self.bins.iter().position(|n| *n > 0).unwrap_or(0);
        let end = self.bins.iter().rposition(|n| *n > 0).map_or(0, |last| last + 1);
        (first..end).map(move |i| {
            let k = (i as i64 - SIDE) as f64;
            ErrorBin { from: k * width, below: (k + 1.0) * width, samples: self.bins[i] }
        })
    }

    /// Samples that are infinitely wrong, which no bin holds.
    #[must_use]
    pub const fn infinite(&self) -> u64 {
        self.infinite
    }

    /// Samples that were counted.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.bins.iter().sum::<u64>() + self.infinite
    }

    fn width(&self) -> f64 {
        self.finest * 2.0_f64.powi(self.doublings as i32)
    }

    /// Doubles the width.
    fn coarsen(&mut self) {
        let mut joined = vec![0; self.bins.len()];
        for (i, n) in self.bins.iter().enumerate() {
            joined[((i as i64 - SIDE).div_euclid(2) + SIDE) as usize] += n;
        }
        self.bins = joined;
        self.doublings += 1;
    }
}

impl Metric for Histogram {
    const FIGURES: &'static [Figure] = &[];
    type Sums = ErrorHistogram;
    type Outcome = ErrorHistogram;

    fn new(subject: &Subject<'_>) -> Self {
        let span = subject.reference.range().span();
        let finest = if subject.layout().sample.is_integer() {
            1.0
        } else {
            // The exponent of a span that is a normal number: 0 has that of 1.
            let exponent = if span > 0.0 { (span.to_bits() >> 52) as i32 - 1023 } else { 0 };
            2.0_f64.powi(exponent - 24)
        };
        Self { finest }
    }

    fn slab(&self, slab: &Slab<'_>) -> ErrorHistogram {
        let errors = slab.errors();
        let finite = |e: f64| if e.is_finite() { e } else { 0.0 };
        let (low, high) =
            errors.iter().fold((0.0_f64, 0.0_f64), |(l, h), e| (l.min(finite(*e)), h.max(finite(*e))));
        let mut histogram = ErrorHistogram { finest: self.finest, ..ErrorHistogram::default() };
        while (low / histogram.width()).floor() < -SIDE as f64
            || (high / histogram.width()).floor() >= SIDE as f64
        {
            histogram.doublings += 1;
        }
        let per_unit = 1.0 / histogram.width();
        histogram.bins = vec![0; 2 * SIDE as usize];
        for e in errors {
            if e.is_finite() {
                let (at, truncated) = (e * per_unit, (e * per_unit) as i64);
                let floor = truncated - i64::from(at < truncated as f64);
                histogram.bins[(floor + SIDE) as usize] += 1;
            } else {
                histogram.infinite += 1;
            }
        }
        histogram
    }

    fn add(&self, sum: &mut ErrorHistogram, mut next: ErrorHistogram) {
        if sum.bins.is_empty() {
            *sum = next;
            return;
        }
        while sum.doublings < next.doublings {
            sum.coarsen();
        }
        while next.doublings < sum.doublings {
            next.coarsen();
        }
        sum.bins.iter_mut().zip(next.bins).for_each(|(sum, next)| *sum += next);
        sum.infinite += next.infinite;
    }

    fn finish(&self, _: &Subject<'_>, sum: ErrorHistogram) -> ErrorHistogram {
        sum
    }

    fn values(_: &ErrorHistogram) -> Vec<Option<f64>> {
        Vec::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::VolumeComparison;
    use crate::metrics::volume::tests::histogram_of;
    use crate::volume::{DenseVolume, Extent, FiniteVolume, Samples, VolumeLayout};

    fn bins(histogram: &ErrorHistogram) -> Vec<(f64, f64, u64)> {
        histogram.bins().map(|bin| (bin.from, bin.below, bin.samples)).collect()
    }

    #[test]
    fn integers_have_a_bin_each() {
        let layout = VolumeLayout::scalar(Extent::new(5, 1, 1).unwrap(), crate::volume::SampleType::U8);
        let samples = Samples::U8(vec![0, 10, 20, 255, 30]);
        let original = FiniteVolume::new(DenseVolume::new(layout, samples).unwrap());
        let mut comparison = VolumeComparison::new(&original, None);
        comparison.add_frame(&[1.2, 8.0, 20.0, 254.6, 30.0]);
        let (error, histogram) = comparison.finish_with_histogram();
        assert_eq!(bins(&histogram), [(-2.0, -1.0, 1), (-1.0, 0.0, 0), (0.0, 1.0, 3), (1.0, 2.0, 1)]);
        assert_eq!((histogram.samples(), error.max_abs_error), (5, 2.0));
    }

    #[test]
    fn bins_grow_until_every_error_has_one_whatever_comes_first() {
        // A constant original of floats begins with bins of 2⁻²⁴; −3 needs bins of 1/64, for 256 of them reach −4.
        let width = 1.0 / 64.0;
        let mut errors = vec![0.0; 9];
        (errors[0], errors[8]) = (-3.0, 0.5);
        let expected = |n: u64| vec![(-3.0, -3.0 + width, 1), (0.0, width, n), (0.5, 0.5 + width, 1)];
        let occupied = |errors: &[f32]| -> Vec<_> {
            bins(&histogram_of([1, 1, 9], errors)).into_iter().filter(|bin| bin.2 > 0).collect()
        };
        assert_eq!(occupied(&errors), expected(7));
        errors.reverse();
        assert_eq!(occupied(&errors), expected(7));
        // The lower end belongs to its bin, the upper to the next.
        errors[4] = width as f32;
        assert_eq!(occupied(&errors)[2], (width, 2.0 * width, 1));
        errors[4] = -f32::MIN_POSITIVE;
        assert_eq!(occupied(&errors)[1], (-width, 0.0, 1));
    }

    #[test]
    fn no_errors_are_one_bin_and_infinite_ones_are_counted_apart() {
        let equal = histogram_of([2, 2, 9], &[0.0; 36]);
        assert_eq!(bins(&equal), [(0.0, 2.0_f64.powi(-24), 36)]);
        let histogram = histogram_of([3, 1, 1], &[f32::NAN, 0.0, f32::NEG_INFINITY]);
        assert_eq!((histogram.infinite(), histogram.samples(), histogram.bins().count()), (2, 3, 1));
    }
}
