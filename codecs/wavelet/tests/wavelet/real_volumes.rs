//! PSNR and rate on real volumes, compared with SPERR as peers measured it. Skips without `CVR_DATA`.

use std::sync::Arc;

use cvr_codec_tests::real::{folder, volume_of};
use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, Settings, decode_frame, encode_temporary};
use cvr_core::metrics::VolumeError;
use cvr_core::volume::{BrickSource as _, FiniteVolume, FrameIndex, NoReferences};
use cvr_wavelet::Wavelet;

/// PSNR in dB, bits per voxel of the whole file, and largest error.
fn measured(volume: &FiniteVolume, settings: &Settings) -> (f64, f64, f64) {
    let stream = Arc::new(encode_temporary(&Wavelet, settings, volume).unwrap());
    let layout = volume.layout();
    let voxels = layout.extent.voxels() * u64::from(layout.frames);
    let bits = 8.0 * stream.file_bytes() as f64 / voxels as f64;
    let decoder = Wavelet.decoder(stream).unwrap();
    let frames = (0..layout.frames).map(FrameIndex);
    let error = VolumeError::compare(
        volume,
        frames.map(|f| decode_frame(decoder.as_ref(), f, &NoReferences).unwrap()),
    );
    (error.psnr_db, bits, error.max_abs_error)
}

/// At 0.25, 0.5 and 1 bit of the whole file, the PSNR is at least `more` above that of SPERR's payload.
fn beats(name: &str, sperr: [f64; 3], more: f64) {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, name);
    for (rate, sperr) in ["0.25", "0.5", "1"].into_iter().zip(sperr) {
        let (psnr, bits, _) = measured(&volume, &settings(&[("bits_per_voxel", rate)]));
        println!("| {name} | {rate} | {bits:.4} | {psnr:.3} | {sperr:.3} | {:+.3} |", psnr - sperr);
        let asked: f64 = rate.parse().unwrap();
        assert!((0.99 * asked..=asked).contains(&bits), "{name} {rate}: {bits} bits");
        assert!(psnr >= sperr + more, "{name} {rate}: {psnr} dB, SPERR {sperr}");
    }
}

#[test]
fn bonsai() {
    beats("bonsai", [44.449, 49.335, 56.096], 2.0);
}

#[test]
fn chest() {
    beats("lidc_chest", [39.385, 44.616, 52.61], 2.0);
}

#[test]
fn magnetic_resonance_head() {
    beats("mr_vs", [36.294, 39.949, 44.741], 0.4);
}

#[test]
fn vorticity() {
    beats("vorticity", [41.92, 45.249, 49.855], -0.5);
}

/// The reversible filter loses nothing, and a bound holds.
#[test]
fn colours_and_frames() {
    let Some(folder) = folder() else { return };
    let (_, bits, error) = measured(&volume_of(&folder, "dti_rgb"), &settings(&[("filter", "5-3")]));
    assert_eq!(error, 0.0);
    assert!(bits < 24.0, "{bits} bits");
    let (psnr, _, error) = measured(&volume_of(&folder, "pcasl"), &settings(&[("max_error", "150")]));
    assert!(error <= 150.0 && psnr > 30.0, "{error}, {psnr} dB");
}
