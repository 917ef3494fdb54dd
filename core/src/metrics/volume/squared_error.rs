//! Squared error: RMSE, and PSNR of all samples and of each colour.
//!
//! The peak is max − min of the whole original, over all frames and channels. A constant original has no peak: its PSNR
//! is infinite when all is equal, and else taken at peak 1.

use super::metric::{Metric, Subject};
use super::slab::Slab;
use crate::metrics::{Better, Figure, psnr_db};

/// Sums of squares, in the order of blocks.
pub(super) struct Squared;

/// Sums over all samples, and over each channel.
#[derive(Copy, Clone, Debug, Default)]
pub(super) struct Squares {
    pub(super) all: f64,
    channels: [f64; 3],
}

/// Mean squared error and PSNR.
#[derive(Copy, Clone, Debug)]
pub(super) struct SquaredError {
    pub(super) mse: f64,
    pub(super) psnr_db: f64,
    pub(super) channel_psnr_db: [Option<f64>; 3],
}

const fn psnr(
    name: &'static str,
    heading: &'static str,
    axis: &'static str,
    definition: &'static str,
) -> Figure {
    Figure { name, heading, axis, unit: "dB", better: Better::Higher, definition }
}

impl Metric for Squared {
    const FIGURES: &'static [Figure] = &[
        psnr(
            "psnr_db",
            "PSNR, dB",
            "PSNR of the voxels, dB",
            "20 log₁₀(peak) − 10 log₁₀(mean of e²), with the peak max − min of the whole original",
        ),
        psnr(
            "psnr_red_db",
            "PSNR of red, dB",
            "PSNR of red, dB",
            "the same of red alone, with the peak of all",
        ),
        psnr("psnr_green_db", "PSNR of green, dB", "PSNR of green, dB", "of green"),
        psnr("psnr_blue_db", "PSNR of blue, dB", "PSNR of blue, dB", "of blue"),
        Figure {
            name: "rmse",
            heading: "RMSE",
            axis: "RMSE of the voxels, data units",
            unit: "data units",
            better: Better::Lower,
            definition: "root of the mean of e² over all samples",
        },
    ];
    type Sums = Squares;
    type Outcome = SquaredError;

    fn new(_: &Subject<'_>) -> Self {
        Self
    }

    fn slab(&self, slab: &Slab<'_>) -> Squares {
        let errors = slab.errors();
        let mut sums = Squares::default();
        for (channel, voxels) in slab.blocks() {
            let block = voxels.fold(0.0, |sum, at| sum + errors[at] * errors[at]);
            sums.all += block;
            sums.channels[channel] += block;
        }
        sums
    }

    fn add(&self, sums: &mut Squares, next: Squares) {
        sums.all += next.all;
        (0..3).for_each(|c| sums.channels[c] += next.channels[c]);
    }

    fn finish(&self, subject: &Subject<'_>, sums: Squares) -> SquaredError {
        let layout = subject.layout();
        let peak = subject.reference.range().span();
        let of_channel =
            |squared| (layout.channels == 3).then(|| psnr_db(squared / layout.voxels() as f64, peak));
        let mse = sums.all / layout.samples() as f64;
        let channel_psnr_db = sums.channels.map(of_channel);
        SquaredError { mse, psnr_db: psnr_db(mse, peak), channel_psnr_db }
    }

    fn values(outcome: &SquaredError) -> Vec<Option<f64>> {
        let rmse = Some(outcome.mse.sqrt());
        std::iter::once(Some(outcome.psnr_db)).chain(outcome.channel_psnr_db).chain([rmse]).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::metrics::volume::tests::error_of;

    #[test]
    fn rmse_is_the_root_of_the_mean_square() {
        // (9 + 16 + 0 + 0) / 4 = 6.25.
        assert_eq!(error_of([4, 1, 1], &[3.0, -4.0, 0.0, 0.0], None).value("rmse"), Some(2.5));
        assert_ne!(error_of([4, 1, 1], &[3.0, -4.0, 0.0, 0.1], None).value("rmse"), Some(2.5));
        assert_eq!(error_of([2, 1, 1], &[f32::NAN, 0.0], None).value("rmse"), Some(f64::INFINITY));
    }
}
