//! Targets are met, or refused with a way out.

use cvr_codec_tests::{bytes, hash};
use cvr_core::codec::EncodeError;
use cvr_core::metrics::VolumeError;
use cvr_core::volume::{
    BrickSource as _, DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout,
};

use super::codec::{METHODS, decoded, encoded, of, source};

fn smooth() -> FiniteVolume {
    bytes([45, 39, 33], 1, 1, |p, _, _| (p[0] * p[1] / 9 + p[2] * 2) as u8 / 2 + hash(p, 3) / 32)
}

fn floats() -> FiniteVolume {
    let extent = Extent::new(29, 21, 18).unwrap();
    let value = |i: u64| {
        let [x, y, z] = extent.position(i as usize).map(|v| v as f32);
        (x * 0.3).sin() * (y * 0.2).cos() * 1e-3 + z * 2e-5 + f32::from(hash([i as u32, 0, 0], 1)) * 1e-7
    };
    let samples = Samples::F32((0..extent.voxels()).map(value).collect());
    let layout = VolumeLayout::scalar(extent, SampleType::F32);
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

fn worst(volume: &FiniteVolume, decoded: &[f32]) -> f64 {
    let pairs = source(volume).into_iter().zip(decoded);
    pairs.map(|(s, d)| (f64::from(s) - f64::from(*d)).abs()).fold(0.0, f64::max)
}

/// Many coefficients of the first volume are equal, so bits jump from step to step.
#[test]
fn a_rate_is_used_up_and_not_exceeded() {
    for (volume, rates) in [(smooth(), [1.0, 2.5, 4.0]), (floats(), [4.0, 6.0, 8.0])] {
        for method in METHODS {
            for rate in rates {
                let stream = encoded(&volume, &of(method, "rate", &rate.to_string())).unwrap();
                let bits = 8.0 * stream.file_bytes() as f64 / volume.layout().voxels() as f64;
                assert!(bits <= rate && bits >= 0.99 * rate, "{method:?}: {bits} of {rate}");
            }
        }
    }
}

#[test]
fn more_bits_than_all_need_are_not_used() {
    let volume = smooth();
    for method in METHODS {
        let exact = encoded(&volume, &of(method, "lossless", "")).unwrap();
        for (target, value) in [("rate", "12"), ("psnr", "90"), ("max_error", "0.5")] {
            let stream = encoded(&volume, &of(method, target, value)).unwrap();
            assert_eq!(stream.payload_bytes(), exact.payload_bytes(), "{method:?} {target}");
            assert_eq!(decoded(&stream), source(&volume));
        }
    }
}

#[test]
fn a_psnr_is_reached_and_not_by_much() {
    for volume in [smooth(), floats()] {
        for method in METHODS {
            for psnr in [30.0, 42.0] {
                let stream = encoded(&volume, &of(method, "psnr", &psnr.to_string())).unwrap();
                let found = VolumeError::compare(&volume, [decoded(&stream)]).psnr_db;
                assert!(found >= psnr && found < psnr + 0.3, "{method:?}: {found} of {psnr}");
            }
        }
    }
}

#[test]
fn no_sample_errs_by_more_than_the_bound() {
    for (volume, bounds) in [(smooth(), [1.0, 4.5]), (floats(), [1e-6, 1e-4])] {
        for method in METHODS {
            for bound in bounds {
                let stream = encoded(&volume, &of(method, "max_error", &bound.to_string())).unwrap();
                let found = worst(&volume, &decoded(&stream));
                assert!(found <= bound && found > 0.5 * bound, "{method:?}: {found} of {bound}");
                assert_eq!(stream.spec().report.error_bound, Some(found));
            }
        }
    }
}

#[test]
fn what_cannot_be_met_is_refused_with_a_way_out() {
    let refused = |volume: &FiniteVolume, target, value| match encoded(volume, &of(METHODS[0], target, value))
        .unwrap_err()
    {
        EncodeError::Unsupported(text) => text,
        other => panic!("{other}"),
    };
    assert!(refused(&smooth(), "rate", "0.05").contains("or use blocks of 16"));
    assert!(refused(&floats(), "max_error", "1e-12").contains("allow as much"));
    assert!(refused(&floats(), "psnr", "139.9").contains("ask for a lower psnr"));
}
