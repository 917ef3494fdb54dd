//! Targets are met on volumes from formulas, or refused with a way out.

use std::sync::Arc;

use cvr_codec_tests::{bytes, settings};
use cvr_core::codec::{Codec as _, ConfigError, EncodeError, Settings, decode_frame, encode_temporary};
use cvr_core::container::EncodedVolume;
use cvr_core::metrics::VolumeError;
use cvr_core::volume::{
    BrickSource as _, DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, SampleType, Samples,
    VolumeLayout,
};
use cvr_wavelet::Wavelet;

/// Waves, an edge, and noise in the lowest bits.
fn volume(channels: u32, frames: u32) -> FiniteVolume {
    bytes([61, 47, 38], channels, frames, |[x, y, z], channel, frame| {
        let wave = (0.2 * f64::from(x + 3 * frame)).sin() * (0.13 * f64::from(y + 9 * channel)).cos();
        let edge = if 2 * x + y > 3 * z { 60.0 } else { 0.0 };
        let noise = f64::from(cvr_codec_tests::hash([x, y, z], channel + frame) & 3);
        (90.0 + 70.0 * wave + edge + noise) as u8
    })
}

/// The same shapes in single precision, far from 0.
fn floats() -> FiniteVolume {
    let of = volume(1, 1);
    let values = of.dense().frame_values(FrameIndex::FIRST).into_iter().map(|v| 5000.0 + 0.37 * v).collect();
    let layout = VolumeLayout { sample: SampleType::F32, ..of.layout().clone() };
    FiniteVolume::new(DenseVolume::new(layout, Samples::F32(values)).unwrap())
}

fn encoded(volume: &FiniteVolume, pairs: &[(&str, &str)]) -> Result<Arc<EncodedVolume>, EncodeError> {
    encode_temporary(&Wavelet, &settings(pairs), volume).map(Arc::new)
}

fn error(volume: &FiniteVolume, stream: &Arc<EncodedVolume>) -> VolumeError {
    let decoder = Wavelet.decoder(Arc::clone(stream)).unwrap();
    let frames = (0..volume.layout().frames).map(FrameIndex);
    VolumeError::compare(volume, frames.map(|f| decode_frame(decoder.as_ref(), f, &NoReferences).unwrap()))
}

#[test]
fn a_rate_is_used_up_by_every_coder() {
    let coders = ["contexts", "runs", "deflate", "arithmetic", "zerotree"];
    for (coder, (channels, frames)) in coders.into_iter().zip([(1, 1), (3, 1), (1, 2), (1, 1), (1, 1)]) {
        let volume = volume(channels, frames);
        for rate in [2.5, 4.0] {
            let pairs = [("coder", coder), ("bits_per_voxel", &rate.to_string()), ("filter", "cdf-2-6")];
            let stream = encoded(&volume, &pairs).unwrap();
            let bits = 8.0 * stream.file_bytes() as f64 / (61.0 * 47.0 * 38.0 * f64::from(frames));
            assert!((0.985 * rate..=rate).contains(&bits), "{coder}: {bits} bits of {rate}");
        }
    }
}

#[test]
fn a_psnr_is_reached_and_not_by_much() {
    for (volume, filter) in [(volume(1, 2), "cdf-9-7"), (volume(3, 1), "5-3"), (floats(), "coiflet-6")] {
        for psnr in [30.0, 47.0] {
            let stream = encoded(&volume, &[("filter", filter), ("psnr", &psnr.to_string())]).unwrap();
            let found = error(&volume, &stream).psnr_db;
            assert!((psnr..=1.01 * psnr).contains(&found), "{filter}: {found} dB of {psnr}");
        }
    }
}

#[test]
fn no_sample_errs_by_more_than_the_bound() {
    for (volume, filter, bound) in [
        (volume(1, 2), "cdf-9-7", 1.0),
        (volume(3, 1), "5-3", 4.7),
        (volume(1, 1), "haar", 9.0),
        (floats(), "cdf-9-7", 0.01),
        (floats(), "daubechies-4", 3.0),
    ] {
        let stream = encoded(&volume, &[("filter", filter), ("max_error", &bound.to_string())]).unwrap();
        let found = error(&volume, &stream).max_abs_error;
        assert!(found <= bound && found > 0.3 * bound, "{filter}: {found} of {bound}");
        assert!(stream.spec().report.error_bound.is_some_and(|told| found <= told && told <= bound));
    }
}

#[test]
fn higher_quality_is_closer() {
    let volume = volume(1, 1);
    let psnr = |quality: &str, scale: &str| {
        let pairs =
            [("quality", quality), ("quant_scale", scale), ("coder", "zerotree"), ("filter", "cdf-2-6")];
        error(&volume, &encoded(&volume, &pairs).unwrap()).psnr_db
    };
    let all = [psnr("0", "paper"), psnr("127", "paper"), psnr("255", "paper"), psnr("255", "printed")];
    assert!(all.windows(2).all(|pair| pair[0] < pair[1]), "{all:?}");
}

#[test]
fn a_constant_volume_is_exact_under_every_target() {
    let value = -1234.567_f32;
    let layout = VolumeLayout::scalar(Extent::new(9, 8, 7).unwrap(), SampleType::F32);
    let volume = FiniteVolume::new(DenseVolume::new(layout, Samples::F32(vec![value; 504])).unwrap());
    for target in [("psnr", "40"), ("max_error", "0.001"), ("quality", "3"), ("bits_per_voxel", "50")] {
        let stream = encoded(&volume, &[target]).unwrap();
        assert_eq!(error(&volume, &stream).max_abs_error, 0.0, "{target:?}");
    }
}

#[test]
fn what_cannot_be_met_is_refused_with_a_way_out() {
    let refused = |volume: &FiniteVolume, pairs: &[(&str, &str)]| match encoded(volume, pairs).unwrap_err() {
        EncodeError::Unsupported(text) => text,
        other => panic!("{other}"),
    };
    assert!(refused(&volume(1, 1), &[("bits_per_voxel", "0.05")]).contains("that index and header take"));
    assert!(refused(&floats(), &[("filter", "5-3")]).contains("use cdf-9-7"));
    assert!(refused(&floats(), &[("max_error", "1e-9")]).contains("ask for a larger one"));
}

#[test]
fn settings_that_contradict_each_other_are_refused() {
    for (pairs, told) in [
        (&[("psnr", "40"), ("max_error", "2")][..], "`psnr` and `max_error` are both targets"),
        (&[("block", "8")], "needs `filter = \"haar\"` or \"5-3\""),
        (&[("filter", "5-3"), ("quality", "100")], "`quality` is the paper's quantiser"),
    ] {
        let complete: Settings = Wavelet.info().complete(&settings(pairs)).unwrap();
        match Wavelet.encoder(&complete).unwrap_err() {
            ConfigError::Contradiction(text) => assert!(text.contains(told), "{text}"),
            other => panic!("{other}"),
        }
    }
}
