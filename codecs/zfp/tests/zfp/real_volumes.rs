//! PSNR and rate on real volumes, compared with zfp as peers measured it. Skips without `CVR_DATA`.
//!
//! The table of docs/benchmarks/zfp.md:
//! `CVR_DATA=folder cargo test --release -p cvr-zfp --test zfp real_volumes -- --nocapture --test-threads=1`

use std::sync::Arc;

use cvr_codec_tests::real::{cpu_time, folder, volume_of};
use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, decode_frame, encode_temporary};
use cvr_core::metrics::VolumeError;
use cvr_core::volume::{BrickSource as _, DenseVolume, FiniteVolume, FrameIndex, NoReferences, Samples};
use cvr_zfp::Zfp;

/// Decibels by which a PSNR may differ from the peers'. They code (v − min) / (max − min), which has other exponents.
const TOLERANCE_DB: f64 = 0.7;
/// The same for a volume that is scaled like theirs.
const SCALED_TOLERANCE_DB: f64 = 0.002;

/// PSNR of the peers at rates 1, 2, 4 and 8.
const VORTICITY: [f64; 4] = [37.063, 41.995, 52.365, 76.111];
const VISCOUS_FINGERS: [f64; 4] = [46.739, 60.312, 78.247, 104.474];

/// Figures at one rate: PSNR in dB, bits per sample of the whole file.
fn measured(name: &str, volume: &FiniteVolume, rate: &str, peer: f64) -> (f64, f64) {
    let begun = cpu_time();
    let stream = Arc::new(encode_temporary(&Zfp, &settings(&[("rate", rate)]), volume).unwrap());
    let encoded = (cpu_time() - begun).as_secs_f64();
    let layout = volume.layout();
    let bits = 8.0 * stream.file_bytes() as f64 / layout.samples() as f64;
    let bound = stream.spec().report.error_bound.unwrap();
    let decoder = Zfp.decoder(stream).unwrap();
    let begun = cpu_time();
    let frames = (0..layout.frames).map(FrameIndex);
    let decoded: Vec<_> =
        frames.map(|frame| decode_frame(decoder.as_ref(), frame, &NoReferences).unwrap()).collect();
    let seconds = (cpu_time() - begun).as_secs_f64();
    let error = VolumeError::compare(volume, decoded);
    // The bound holds for values that are not clamped.
    assert!(error.max_abs_error <= bound, "{name} {rate}: {} of {bound}", error.max_abs_error);
    println!(
        "| {name} | {rate} | {bits:.4} | {:.3} | {peer:.3} | {:+.3} | {bound:.6} | {encoded:.2} | {seconds:.2} |",
        error.psnr_db,
        error.psnr_db - peer
    );
    (error.psnr_db, bits)
}

/// Compares each of the rates 1, 2, 4 and 8 with the PSNR of the peers.
fn holds(name: &str, peers: [f64; 4]) {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, name);
    for (rate, peer) in ["1", "2", "4", "8"].into_iter().zip(peers) {
        let (psnr, bits) = measured(name, &volume, rate, peer);
        assert!((psnr - peer).abs() < TOLERANCE_DB, "{name} {rate}: {psnr} dB, the peers {peer}");
        // Cut blocks take as many bits as whole ones, and the header of the file counts.
        let [x, y, z] = volume.layout().extent.to_array();
        let filled = [x, y, z].iter().map(|n| n.div_ceil(4) * 4).product::<u32>();
        let expected = rate.parse::<f64>().unwrap() * f64::from(filled) / f64::from(x * y * z);
        assert!((bits - expected).abs() < 0.03, "{name} {rate}: {bits} bits, {expected} are due");
    }
}

/// PSNR of (v − min) / (max − min), in single precision.
fn scaled_psnr(volume: &FiniteVolume, rate: &str) -> f64 {
    let (layout, range) = (volume.layout().clone(), volume.range());
    let factor = 1.0 / (range.max - range.min);
    let frames = (0..layout.frames).map(FrameIndex);
    let values: Vec<f32> = frames.flat_map(|f| volume.dense().frame_values(f)).collect();
    let values = values.into_iter().map(|v| (v - range.min) * factor).collect();
    let scaled = FiniteVolume::new(DenseVolume::new(layout, Samples::F32(values)).unwrap());
    let stream = Arc::new(encode_temporary(&Zfp, &settings(&[("rate", rate)]), &scaled).unwrap());
    let decoder = Zfp.decoder(stream).unwrap();
    let frames = (0..volume.layout().frames).map(FrameIndex);
    let frame = |f| decode_frame(decoder.as_ref(), f, &NoReferences).unwrap();
    VolumeError::compare(&scaled, frames.map(frame)).psnr_db
}

/// Without rounding and cut frames, scaling like the peers gives the peers' PSNR.
#[test]
fn scaled_as_the_peers_do_it_is_their_figure() {
    let Some(folder) = folder() else { return };
    for (name, peers) in [("vorticity", VORTICITY), ("viscous_fingers", VISCOUS_FINGERS)] {
        let volume = volume_of(&folder, name);
        for (rate, peer) in ["1", "2", "4", "8"].into_iter().zip(peers) {
            let psnr = scaled_psnr(&volume, rate);
            assert!((psnr - peer).abs() < SCALED_TOLERANCE_DB, "{name} {rate}: {psnr} dB, the peers {peer}");
        }
    }
}

#[test]
fn bonsai() {
    holds("bonsai", [39.167, 45.428, 55.7, 93.328]);
}

#[test]
fn magnetic_resonance_head() {
    holds("mr_vs", [31.197, 37.559, 48.515, 71.499]);
}

#[test]
fn chest() {
    holds("lidc_chest", [30.327, 34.996, 45.095, 69.003]);
}

#[test]
fn vorticity() {
    holds("vorticity", VORTICITY);
}

#[test]
fn viscous_fingers() {
    holds("viscous_fingers", VISCOUS_FINGERS);
}

#[test]
fn spin_labelling() {
    holds("pcasl", [24.279, 28.666, 38.557, 62.504]);
}

#[test]
fn colours() {
    holds("dti_rgb", [25.823, 29.761, 39.841, 63.46]);
}
