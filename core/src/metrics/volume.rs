//! Error of decoded voxels against the original volume.
//!
//! Conventions, the same as those of the peer measurements this software is compared with:
//! - the peak is max − min of the whole original, over all frames and channels;
//! - where samples are integers, a decoded value is rounded to the nearest integer and clamped to the original's
//!   min..=max first, for that is what a file of that type would hold;
//! - a constant original has no peak: its PSNR is infinite when all is equal, and else taken at peak 1;
//! - the *foreground* leaves out blocks of 4³ voxels (of one frame and one channel; cut at the edge) all of whose
//!   originals lie within 2 % of the range from the modal value, the centre of the fullest of 256 bins over
//!   min..max; half a bin is added, since the mode is known no better.

use rayon::prelude::*;

use super::psnr_db;
use crate::volume::{BrickSource, FiniteVolume, FrameIndex, VolumeLayout};

/// Side of the blocks that are foreground or not.
const BLOCK: usize = 4;
/// Bins of the histogram whose fullest one holds the modal value.
const BINS: usize = 256;
/// Distance from the modal value, as a fraction of the range, up to which a voxel is background.
const NEAR: f64 = 0.02 + 0.5 / BINS as f64;

/// Error of a decoded volume, over all frames and channels.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct VolumeError {
    /// PSNR over all voxels; infinite without error.
    pub psnr_db: f64,
    /// PSNR over the foreground; `None` when there is none (a constant volume has none).
    pub foreground_psnr_db: Option<f64>,
    /// Largest absolute difference in data units; infinite when a decoded value is no number.
    pub max_abs_error: f64,
    /// Mean squared error in squared data units.
    pub mse: f64,
    /// PSNR of red, green and blue, each with the volume's own peak; of a scalar volume `None`.
    pub channel_psnr_db: [Option<f64>; 3],
}

/// Error of one decoded frame.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct FrameError {
    /// PSNR of the frame, with the peak of the whole volume.
    pub psnr_db: f64,
    /// Largest absolute difference in data units.
    pub max_abs_error: f64,
}

impl VolumeError {
    /// Compares all frames of a decoded volume with the original.
    ///
    /// # Panics
    /// When frames or samples are too few or too many.
    #[must_use]
    pub fn compare<F: AsRef<[f32]>>(
        reference: &FiniteVolume,
        decoded: impl IntoIterator<Item = F>,
    ) -> VolumeError {
        let mut comparison = VolumeComparison::new(reference);
        for frame in decoded {
            comparison.add_frame(frame.as_ref());
        }
        comparison.finish()
    }
}

/// A comparison that takes the decoded frames one after the other, so that only one need be in memory.
#[derive(Debug)]
pub struct VolumeComparison<'a> {
    reference: &'a FiniteVolume,
    mode: f64,
    frames: u32,
    sums: Sums,
}

/// What one slab of blocks adds.
#[derive(Copy, Clone, Debug, Default)]
struct Sums {
    squared: f64,
    channel_squared: [f64; 3],
    foreground_squared: f64,
    foreground_samples: u64,
    max: f64,
}

impl Sums {
    fn plus(self, other: Self) -> Self {
        Self {
            squared: self.squared + other.squared,
            channel_squared: std::array::from_fn(|c| self.channel_squared[c] + other.channel_squared[c]),
            foreground_squared: self.foreground_squared + other.foreground_squared,
            foreground_samples: self.foreground_samples + other.foreground_samples,
            max: self.max.max(other.max),
        }
    }
}

impl<'a> VolumeComparison<'a> {
    /// Finds the modal value of the original.
    #[must_use]
    pub fn new(reference: &'a FiniteVolume) -> Self {
        Self { reference, mode: mode(reference), frames: 0, sums: Sums::default() }
    }

    /// Compares the next frame: x fastest, channels interleaved. Returns the error of this frame alone.
    ///
    /// # Panics
    /// When the original has no further frame, or not this many samples in one.
    pub fn add_frame(&mut self, decoded: &[f32]) -> FrameError {
        let layout = self.reference.layout();
        assert!(self.frames < layout.frames, "the original has {} frames", layout.frames);
        assert_eq!(decoded.len() as u64, layout.samples_per_frame(), "samples of a decoded frame");
        let original = self.reference.dense().frame_values(FrameIndex(self.frames));
        let [x, y, _] = layout.extent.to_array().map(|n| n as usize);
        let slab = x * y * BLOCK * layout.channels as usize;
        // Slabs are fixed pieces and are added up in their order, whichever thread has done them.
        let slabs: Vec<Sums> = original
            .par_chunks(slab)
            .zip(decoded.par_chunks(slab))
            .map(|(original, decoded)| self.slab(layout, original, decoded))
            .collect();
        let frame = slabs.into_iter().fold(Sums::default(), Sums::plus);
        self.sums = self.sums.plus(frame);
        self.frames += 1;
        let mse = frame.squared / layout.samples_per_frame() as f64;
        FrameError { psnr_db: psnr_db(mse, self.reference.range().span()), max_abs_error: frame.max }
    }

    /// The error over all frames.
    ///
    /// # Panics
    /// When a frame of the original has not been compared.
    #[must_use]
    pub fn finish(self) -> VolumeError {
        let layout = self.reference.layout();
        assert_eq!(self.frames, layout.frames, "compared frames");
        let peak = self.reference.range().span();
        let Sums { squared, channel_squared, foreground_squared, foreground_samples, max } = self.sums;
        let channel_psnr_db = channel_squared
            .map(|squared| (layout.channels == 3).then(|| psnr_db(squared / layout.voxels() as f64, peak)));
        let mse = squared / layout.samples() as f64;
        let foreground_mse = foreground_squared / foreground_samples as f64;
        VolumeError {
            psnr_db: psnr_db(mse, peak),
            foreground_psnr_db: (foreground_samples > 0).then(|| psnr_db(foreground_mse, peak)),
            max_abs_error: max,
            mse,
            channel_psnr_db,
        }
    }

    /// One slab, `BLOCK` voxels thick or what is left of it.
    fn slab(&self, layout: &VolumeLayout, original: &[f32], decoded: &[f32]) -> Sums {
        let channels = layout.channels as usize;
        let [x, y, _] = layout.extent.to_array().map(|n| n as usize);
        let z = original.len() / (x * y * channels);
        let mut sums = Sums::default();
        for y0 in (0..y).step_by(BLOCK) {
            for x0 in (0..x).step_by(BLOCK) {
                let (y1, x1) = ((y0 + BLOCK).min(y), (x0 + BLOCK).min(x));
                for channel in 0..channels {
                    let voxels = (0..z).flat_map(move |z| {
                        (y0..y1).flat_map(move |v| {
                            (x0..x1).map(move |u| ((z * y + v) * x + u) * channels + channel)
                        })
                    });
                    let mut block = self.block(voxels, original, decoded);
                    block.channel_squared[channel] = block.squared;
                    sums = sums.plus(block);
                }
            }
        }
        sums
    }

    fn block(&self, voxels: impl Iterator<Item = usize>, original: &[f32], decoded: &[f32]) -> Sums {
        let range = self.reference.range();
        let (min, max, span) = (f64::from(range.min), f64::from(range.max), range.span());
        let integer = self.reference.layout().sample.is_integer();
        let mut sums = Sums::default();
        let mut samples = 0;
        let mut foreground = false;
        for at in voxels {
            let (original, mut value) = (f64::from(original[at]), f64::from(decoded[at]));
            if integer {
                value = value.round().clamp(min, max);
            }
            let difference = (value - original).abs();
            // `f64::max` would drop a NaN: what is no number is infinitely wrong.
            let difference = if difference.is_nan() { f64::INFINITY } else { difference };
            sums.squared += difference * difference;
            sums.max = sums.max.max(difference);
            samples += 1;
            foreground |= span > 0.0 && ((original - min) / span - self.mode).abs() > NEAR;
        }
        if foreground {
            sums.foreground_squared = sums.squared;
            sums.foreground_samples = samples;
        }
        sums
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{DenseVolume, Extent, SampleType, Samples};

    fn volume(extent: [u32; 3], samples: Samples, frames: u32) -> FiniteVolume {
        let mut layout = VolumeLayout::scalar(Extent::try_from(extent).unwrap(), samples.sample_type());
        layout.frames = frames;
        FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
    }

    fn values(volume: &FiniteVolume) -> Vec<f32> {
        volume.dense().frame_values(FrameIndex::FIRST)
    }

    fn noise(n: usize) -> Vec<u8> {
        (0..n as u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect()
    }

    #[test]
    fn equal_volumes_have_no_error_and_one_unit_is_noticed() {
        let original = volume([13, 17, 23], Samples::U8(noise(13 * 17 * 23)), 1);
        let mut decoded = values(&original);
        let equal = VolumeError::compare(&original, [&decoded]);
        assert_eq!((equal.psnr_db, equal.max_abs_error, equal.mse), (f64::INFINITY, 0.0, 0.0));
        assert_eq!(equal.foreground_psnr_db, Some(f64::INFINITY));

        decoded[4000] += if decoded[4000] > 0.0 { -1.0 } else { 1.0 };
        let changed = VolumeError::compare(&original, [&decoded]);
        assert_eq!(changed.max_abs_error, 1.0);
        assert_eq!(changed.mse, 1.0 / f64::from(13 * 17 * 23));
        assert!(changed.psnr_db.is_finite());
    }

    #[test]
    fn channels_and_frames_have_errors_of_their_own() {
        let mut layout = VolumeLayout::scalar(Extent::new(5, 3, 2).unwrap(), SampleType::U8);
        (layout.channels, layout.frames) = (3, 2);
        let original = FiniteVolume::new(DenseVolume::new(layout, Samples::U8(noise(180))).unwrap());
        let mut frames = [0, 1].map(|frame| original.dense().frame_values(FrameIndex(frame)));
        // Green of one voxel of the second frame.
        frames[1][3 * 7 + 1] += if frames[1][3 * 7 + 1] > 100.0 { -3.0 } else { 3.0 };
        let mut comparison = VolumeComparison::new(&original);
        assert_eq!(
            comparison.add_frame(&frames[0]),
            FrameError { psnr_db: f64::INFINITY, max_abs_error: 0.0 }
        );
        let second = comparison.add_frame(&frames[1]);
        assert!(second.psnr_db.is_finite() && second.max_abs_error == 3.0);
        let whole = comparison.finish();
        let [red, green, blue] = whole.channel_psnr_db.map(Option::unwrap);
        assert_eq!((red, blue), (f64::INFINITY, f64::INFINITY));
        // Half as many samples as in both frames and a third of the channels.
        assert!((whole.psnr_db - second.psnr_db - 10.0 * 2_f64.log10()).abs() < 1e-9);
        assert!((whole.psnr_db - green - 10.0 * 3_f64.log10()).abs() < 1e-9);
        let scalar = volume([4, 1, 1], Samples::U8(vec![10, 20, 30, 40]), 1);
        let equal = VolumeError::compare(&scalar, [values(&scalar)]);
        assert_eq!(equal.channel_psnr_db, [None; 3]);
    }

    #[test]
    fn integers_are_rounded_and_clamped_and_floats_are_not() {
        let original = volume([4, 1, 1], Samples::U8(vec![10, 20, 30, 40]), 1);
        let decoded = [-99.0, 20.4, 30.49, 1e9];
        assert_eq!(VolumeError::compare(&original, [&decoded]).mse, 0.0);
        assert_eq!(VolumeError::compare(&original, [&[10.0, 20.6, 30.0, 40.0]]).max_abs_error, 1.0);

        let original = volume([4, 1, 1], Samples::F32(vec![10.0, 20.0, 30.0, 40.0]), 1);
        let error = VolumeError::compare(&original, [&[10.0, 20.0, 30.0, 40.5]]);
        assert_eq!((error.max_abs_error, error.mse), (0.5, 0.0625));
        assert!((error.psnr_db - 10.0 * (900.0f64 / 0.0625).log10()).abs() < 1e-12);
        let one_bit = f32::from_bits(30.0f32.to_bits() + 1);
        assert!(VolumeError::compare(&original, [&[10.0, 20.0, one_bit, 40.0]]).mse > 0.0);
    }

    #[test]
    fn what_is_no_number_is_infinitely_wrong() {
        for samples in [Samples::U8(vec![1, 2]), Samples::F32(vec![1.0, 2.0])] {
            let error = VolumeError::compare(&volume([2, 1, 1], samples, 1), [&[f32::NAN, 2.0]]);
            assert_eq!((error.max_abs_error, error.psnr_db), (f64::INFINITY, f64::NEG_INFINITY));
        }
    }

    #[test]
    fn a_constant_volume_has_no_foreground() {
        let original = volume([5, 5, 5], Samples::F32(vec![7.0; 125]), 1);
        let equal = VolumeError::compare(&original, [vec![7.0; 125]]);
        assert_eq!((equal.psnr_db, equal.foreground_psnr_db), (f64::INFINITY, None));
        let off = VolumeError::compare(&original, [vec![7.1; 125]]);
        assert!((off.psnr_db - 20.0).abs() < 1e-4);
    }

    /// One block of 4³ differs from the modal zero; an error outside of it must not count, one inside must.
    #[test]
    fn the_foreground_is_whole_blocks_that_leave_the_mode() {
        let mut samples = vec![0u8; 8 * 8 * 8];
        samples[(5 * 8 + 5) * 8 + 5] = 200;
        let original = volume([8, 8, 8], Samples::U8(samples), 1);
        let mut decoded = values(&original);
        decoded[0] = 3.0;
        let outside = VolumeError::compare(&original, [&decoded]);
        assert_eq!(outside.foreground_psnr_db, Some(f64::INFINITY));
        assert!(outside.psnr_db.is_finite());
        decoded[(7 * 8 + 7) * 8 + 7] = 3.0;
        let inside = VolumeError::compare(&original, [&decoded]);
        let expected = 10.0 * (200.0f64 * 200.0 / (9.0 / 64.0)).log10();
        assert!((inside.foreground_psnr_db.unwrap() - expected).abs() < 1e-9);
    }

    /// The mode 0.5/256 of the range, plus 2 %, plus half a bin: 5.65 of 255 is the last background value.
    #[test]
    fn near_means_two_percent_and_half_a_bin() {
        for (value, expected) in [(6u8, false), (7, true)] {
            let mut samples = vec![0u8; 4 * 4 * 8];
            samples[0] = value;
            samples[100] = 255;
            let original = volume([4, 4, 8], Samples::U8(samples), 1);
            let mut decoded = values(&original);
            decoded[1] = 9.0;
            let counted = VolumeError::compare(&original, [&decoded]).foreground_psnr_db.unwrap().is_finite();
            assert_eq!(counted, expected, "a block that holds {value}");
        }
    }

    #[test]
    fn frames_add_up_and_threads_do_not_matter() {
        let n = 9 * 10 * 11;
        let original = volume([9, 10, 11], Samples::U8(noise(2 * n)), 2);
        let decode = |frame: u32| -> Vec<f32> {
            let values = original.dense().frame_values(FrameIndex(frame));
            values.iter().enumerate().map(|(i, v)| v + (i % 7) as f32 * 0.37).collect()
        };
        let frames = [decode(0), decode(1)];
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| VolumeError::compare(&original, &frames))
        };
        let (one, four) = (on(1), on(4));
        assert_eq!(one.mse.to_bits(), four.mse.to_bits());
        assert_eq!(one, four);
        let first = VolumeError::compare(&volume([9, 10, 11], Samples::U8(noise(n)), 1), [decode(0)]);
        assert!(one.mse > 0.0 && first.mse > 0.0 && one.max_abs_error >= first.max_abs_error);
    }

    #[test]
    fn channels_have_blocks_of_their_own() {
        let mut layout = VolumeLayout::scalar(Extent::cube(4).unwrap(), SampleType::U8);
        layout.channels = 3;
        let mut samples = vec![0u8; 64 * 3];
        samples[1] = 255; // green of the first voxel: only the green block is foreground
        let original = FiniteVolume::new(DenseVolume::new(layout, Samples::U8(samples)).unwrap());
        let mut decoded = values(&original);
        decoded[0] = 9.0;
        assert_eq!(
            VolumeError::compare(&original, [&decoded]).foreground_psnr_db,
            Some(f64::INFINITY),
            "red"
        );
        decoded[4] = 9.0;
        assert!(VolumeError::compare(&original, [&decoded]).foreground_psnr_db.unwrap().is_finite(), "green");
    }
}
