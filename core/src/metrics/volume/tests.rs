//! Tests of what all metrics of voxels share, and of the first of them.

use super::*;
use crate::volume::{DenseVolume, Extent, SampleType, Samples, VolumeLayout};

fn volume(extent: [u32; 3], samples: Samples, frames: u32) -> FiniteVolume {
    let mut layout = VolumeLayout::scalar(Extent::try_from(extent).unwrap(), samples.sample_type());
    layout.frames = frames;
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

/// The comparison of a constant volume of floats whose samples each have the given error.
fn compared(layout: VolumeLayout, errors: &[f32], block: Option<&str>) -> (VolumeError, ErrorHistogram) {
    let samples = Samples::F32(vec![0.0; errors.len()]);
    let original = FiniteVolume::new(DenseVolume::new(layout, samples).unwrap());
    let mut comparison = VolumeComparison::new(&original, block.map(|block| block.parse().unwrap()));
    comparison.add_frame(errors);
    comparison.finish_with_histogram()
}

/// The error of a scalar volume of floats whose voxels each have the given error. `block` is the codec's.
pub(super) fn error_of(extent: [u32; 3], errors: &[f32], block: Option<&str>) -> VolumeError {
    let extent = Extent::try_from(extent).unwrap();
    compared(VolumeLayout::scalar(extent, SampleType::F32), errors, block).0
}

/// The same of three channels.
pub(super) fn error_of_channels(extent: [u32; 3], errors: &[f32]) -> VolumeError {
    let extent = Extent::try_from(extent).unwrap();
    compared(VolumeLayout { channels: 3, ..VolumeLayout::scalar(extent, SampleType::F32) }, errors, None).0
}

/// The histogram of a scalar volume whose voxels have the given errors.
pub(super) fn histogram_of(extent: [u32; 3], errors: &[f32]) -> ErrorHistogram {
    let extent = Extent::try_from(extent).unwrap();
    compared(VolumeLayout::scalar(extent, SampleType::F32), errors, None).1
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
    let mut comparison = VolumeComparison::new(&original, None);
    assert_eq!(comparison.add_frame(&frames[0]), FrameError { psnr_db: f64::INFINITY, max_abs_error: 0.0 });
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
        pool.install(|| {
            let mut comparison = VolumeComparison::new(&original, Some("4".parse().unwrap()));
            frames.iter().for_each(|frame| {
                comparison.add_frame(frame);
            });
            comparison.finish_with_histogram()
        })
    };
    let ((one, counted), (four, again)) = (on(1), on(4));
    assert_eq!(counted, again);
    for figure in list::figures().filter(|figure| !figure.name.contains("psnr_")) {
        let [one, four] = [&one, &four].map(|error| error.value(figure.name).map(f64::to_bits));
        assert!(one.is_some() && one == four, "{}", figure.name);
    }
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
    assert_eq!(VolumeError::compare(&original, [&decoded]).foreground_psnr_db, Some(f64::INFINITY), "red");
    decoded[4] = 9.0;
    assert!(VolumeError::compare(&original, [&decoded]).foreground_psnr_db.unwrap().is_finite(), "green");
}

#[test]
fn figures_have_the_values_of_their_fields() {
    let original = volume([4, 1, 1], Samples::F32(vec![10.0, 20.0, 30.0, 40.0]), 1);
    let error = VolumeError::compare(&original, [&[10.0, 20.0, 30.0, 40.5]]);
    assert_eq!(error.value("psnr_db"), Some(error.psnr_db));
    assert_eq!(error.value("foreground_psnr_db"), error.foreground_psnr_db);
    assert_eq!((error.value("max_abs_error"), error.value("psnr_red_db")), (Some(0.5), None));
    assert_eq!(error.value("no figure"), None);
}
