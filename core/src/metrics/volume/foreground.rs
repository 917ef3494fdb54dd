//! PSNR of the foreground.
//!
//! The *foreground* leaves out blocks of 4³ voxels (of one frame and one channel; cut at the edge) all of whose originals
//! lie within 2 % of the range from the modal value, the centre of the fullest of 256 bins over min..max. Half a bin is
//! added: the mode is not known more exactly.

use super::metric::{Metric, Subject};
use super::slab::Slab;
use crate::metrics::{Better, Figure, psnr_db};
use crate::volume::{BrickSource, FiniteVolume, FrameIndex, ValueRange};

/// Bins of the histogram whose fullest one holds the modal value.
const BINS: usize = 256;
/// Distance from the modal value, as a fraction of the range, up to which a voxel is background.
const NEAR: f64 = 0.02 + 0.5 / BINS as f64;

/// Squares over blocks that are foreground.
pub(super) struct Foreground {
    range: ValueRange,
    mode: f64,
}

/// Sum of squares, and the samples that it is of.
#[derive(Copy, Clone, Debug, Default)]
pub(super) struct Squares {
    sum: f64,
    samples: u64,
}

impl Metric for Foreground {
    const FIGURES: &'static [Figure] = &[Figure {
        name: "foreground_psnr_db",
        heading: "foreground PSNR, dB",
        axis: "PSNR of the foreground voxels, dB",
        unit: "dB",
        better: Better::Higher,
        definition: "`psnr_db` without 4³ blocks all of whose samples lie within 2 % of the modal value",
    }];
    type Sums = Squares;
    type Outcome = Option<f64>;

    fn new(subject: &Subject<'_>) -> Self {
        Self { range: subject.reference.range(), mode: mode(subject.reference) }
    }

    fn slab(&self, slab: &Slab<'_>) -> Squares {
        let (min, span) = (f64::from(self.range.min), self.range.span());
        let errors = slab.errors();
        let mut sums = Squares::default();
        for (_, voxels) in slab.blocks() {
            let mut block = Squares::default();
            let mut foreground = false;
            for at in voxels {
                block.sum += errors[at] * errors[at];
                block.samples += 1;
                let original = f64::from(slab.original[at]);
                foreground |= span > 0.0 && ((original - min) / span - self.mode).abs() > NEAR;
            }
            if foreground {
                self.add(&mut sums, block);
            }
        }
        sums
    }

    fn add(&self, sums: &mut Squares, next: Squares) {
        sums.sum += next.sum;
        sums.samples += next.samples;
    }

    fn finish(&self, _: &Subject<'_>, sums: Squares) -> Option<f64> {
        (sums.samples > 0).then(|| psnr_db(sums.sum / sums.samples as f64, self.range.span()))
    }

    fn values(outcome: &Option<f64>) -> Vec<Option<f64>> {
        vec![*outcome]
    }
}

/// Centre of the fullest bin, as a fraction of the range; the lowest of equally full ones.
fn mode(volume: &FiniteVolume) -> f64 {
    let (min, span) = (f64::from(volume.range().min), volume.range().span());
    let mut bins = [0u64; BINS];
    if span > 0.0 {
        for frame in 0..volume.layout().frames {
            for value in volume.dense().frame_values(FrameIndex(frame)) {
                let unit = (f64::from(value) - min) / span;
                bins[((unit * BINS as f64) as usize).min(BINS - 1)] += 1;
            }
        }
    }
    let fullest = bins.iter().enumerate().rev().max_by_key(|(_, n)| **n).map_or(0, |(bin, _)| bin);
    (fullest as f64 + 0.5) / BINS as f64
}
