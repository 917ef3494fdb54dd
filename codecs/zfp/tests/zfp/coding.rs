//! Properties of the encoder beyond the conformance tests: positions of bits, independent channels and frames, and
//! equal output for any number of threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use cvr_codec_tests::{bytes, hash, settings};
use cvr_core::codec::{
    Codec as _, DecodedForm, EncodeError, Progress, decode_frame, encode_file, encode_temporary,
};
use cvr_core::container::{Element, EncodedVolume};
use cvr_core::volume::{
    DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, Replaced, SampleType, Samples, VolumeLayout,
};
use cvr_zfp::{Parameters, Zfp};

fn encoded(volume: &FiniteVolume, rate: &str) -> Arc<EncodedVolume> {
    Arc::new(encode_temporary(&Zfp, &settings(&[("rate", rate)]), volume).unwrap())
}

fn words(stream: &EncodedVolume) -> Vec<u32> {
    stream.tensor("blocks", Element::U32).unwrap().words().to_vec()
}

fn decoded(stream: &Arc<EncodedVolume>, frame: u32) -> Vec<f32> {
    let decoder = Zfp.decoder(Arc::clone(stream)).unwrap();
    decode_frame(decoder.as_ref(), FrameIndex(frame), &NoReferences).unwrap()
}

fn singles(size: [u32; 3], value: impl Fn(usize) -> f32) -> FiniteVolume {
    let extent = Extent::try_from(size).unwrap();
    let values = (0..extent.voxels() as usize).map(value).collect();
    let layout = VolumeLayout::scalar(extent, SampleType::F32);
    FiniteVolume::new(DenseVolume::new(layout, Samples::F32(values)).unwrap())
}

#[test]
fn a_rate_is_rounded_to_bits_of_a_block_and_blocks_are_packed() {
    let volume = bytes([9, 8, 4], 1, 1, |p, _, _| hash(p, 3));
    for (rate, bits) in [("0.15", 10), ("1", 64), ("1.1", 70), ("3.0078125", 193), ("32", 2048)] {
        let stream = encoded(&volume, rate);
        let parameters: Parameters = stream.parameters().unwrap();
        assert_eq!((parameters.block_bits, parameters.grid), (bits, [3, 2, 1]));
        assert_eq!(words(&stream).len() as u32, (6 * bits).div_ceil(64) * 2, "rate {rate}");
    }
    for rate in ["0.14", "32.1", "0", "many"] {
        let refused = encode_temporary(&Zfp, &settings(&[("rate", rate)]), &volume).unwrap_err();
        assert!(refused.to_string().contains("a number from 0.140625 to 32"), "{refused}");
    }
}

#[test]
fn more_bits_never_err_more() {
    let volume = bytes([21, 18, 13], 1, 1, |p, _, _| hash(p, 9) / 8 + (p[0] * p[1] / 3) as u8);
    let source = volume.dense().frame_values(FrameIndex::FIRST);
    let square = |rate: &str| -> f64 {
        let pairs = decoded(&encoded(&volume, rate), 0).into_iter().zip(&source);
        pairs.map(|(d, s)| f64::from(d - s).powi(2)).sum()
    };
    let squares = ["0.140625", "0.5", "1", "2", "4", "8", "16", "32"].map(square);
    // Until nothing is left to err by.
    assert!(squares.is_sorted_by(|fewer, more| fewer > more || *more == 0.0), "{squares:?}");
    assert_eq!(encoded(&volume, "16").spec().report.error_bound, Some(0.0), "integers are rounded");
}

#[test]
fn nothing_is_one_bit_and_a_constant_is_kept() {
    let nothing = encoded(&bytes([9, 5, 3], 1, 2, |_, _, _| 0), "1");
    assert!(words(&nothing).iter().all(|w| *w == 0) && decoded(&nothing, 1).iter().all(|v| *v == 0.0));
    let constant = bytes([9, 5, 3], 1, 1, |_, _, _| 200);
    let stream = encoded(&constant, "1");
    assert_eq!(stream.spec().report.error_bound, Some(0.0));
    assert_eq!(decoded(&stream, 0), constant.dense().frame_values(FrameIndex::FIRST));
}

/// A channel and a frame are coded like a scalar volume.
#[test]
fn channels_and_frames_are_coded_on_their_own() {
    let value = |p: [u32; 3], c: u32, f: u32| hash(p, 7 * f + c);
    let all = encoded(&bytes([9, 7, 5], 3, 2, value), "1.1");
    let shape = &all.spec().tensors["blocks"].shape;
    let each = shape[2] as usize;
    assert_eq!(shape[..2], [2, 3]);
    for f in 0..2 {
        let frame = decoded(&all, f);
        for c in 0..3 {
            let alone = encoded(&bytes([9, 7, 5], 1, 1, |p, _, _| value(p, c, f)), "1.1");
            let at = (f * 3 + c) as usize * each;
            assert_eq!(words(&all)[at..at + each], words(&alone), "frame {f}, channel {c}");
            let channel: Vec<f32> = frame.iter().skip(c as usize).step_by(3).copied().collect();
            assert_eq!(channel, decoded(&alone, 0), "frame {f}, channel {c}");
        }
    }
}

/// Values where zfp's own arithmetic overflows: magnitudes below 2^-98, and numbers beyond single precision.
#[test]
fn the_ends_of_single_precision_are_kept() {
    let sign = |i: usize| if (i * 2_654_435_761) >> 7 & 1 == 0 { 1.0 } else { -1.0 };
    let smallest = singles([4, 8, 4], |i| sign(i) * f32::MIN_POSITIVE * ((i * 40_503) % 64 + 1) as f32);
    assert!(encoded(&smallest, "32").spec().report.error_bound.unwrap() <= f64::from(f32::MIN_POSITIVE));
    let largest = singles([4, 8, 4], |i| sign(i) * f32::MAX);
    let stream = encoded(&largest, "2");
    assert!(decoded(&stream, 0).iter().all(|v| v.is_finite()));
    assert!(decoded(&stream, 0).contains(&f32::MAX));
}

#[test]
fn a_texel_is_a_single() {
    let stream = encoded(&bytes([8, 8, 8], 1, 1, |p, _, _| hash(p, 9)), "4");
    assert_eq!(Zfp.decoder(stream).unwrap().decoded_form(), DecodedForm::FLOAT32);
}

#[test]
fn any_number_of_threads_gives_the_same_file() {
    let volume = bytes([40, 33, 21], 3, 1, |p, c, _| hash(p, 9 + c) / 8 + (p[0] * p[1] / 9) as u8);
    let folder = tempfile::tempdir().unwrap();
    let on = |threads: usize| {
        let path = folder.path().join(format!("{threads}.cvr"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let pairs = settings(&[("rate", "2.3")]);
        pool.install(|| {
            encode_file(&Zfp, &pairs, &volume, Replaced::default(), &path, &Progress::silent()).unwrap();
        });
        std::fs::read(path).unwrap()
    };
    let one = on(1);
    assert!(one == on(2) && one == on(4), "the bytes depend on the number of threads");
}

#[test]
fn every_voxel_is_reported_once_and_a_user_can_stop() {
    let volume = bytes([13, 10, 11], 3, 2, |p, c, _| hash(p, c));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.cvr");
    let (pairs, flag, done) = (settings(&[]), AtomicBool::new(false), AtomicU64::new(0));
    let count = |voxels| {
        done.fetch_add(voxels, Ordering::Relaxed);
    };
    let run = Progress::new(count, Some(&flag));
    flag.store(true, Ordering::Relaxed);
    let stopped = encode_file(&Zfp, &pairs, &volume, Replaced::default(), &path, &run);
    assert!(matches!(stopped, Err(EncodeError::Cancelled)) && !path.exists(), "{stopped:?}");
    flag.store(false, Ordering::Relaxed);
    done.store(0, Ordering::Relaxed);
    encode_file(&Zfp, &pairs, &volume, Replaced::default(), &path, &run).unwrap();
    assert_eq!(done.load(Ordering::Relaxed), 13 * 10 * 11 * 2);
}
