//! PSNR and rate on real volumes, compared with the k-means of FAISS as peers measured it. Skips without `CVR_DATA`.
//!
//! The table of docs/benchmarks/vq.md:
//! `CVR_DATA=folder cargo test --release -p cvr-vq --test vq real_volumes -- --nocapture --test-threads=1`

use std::sync::Arc;

use cvr_codec_tests::real::{cpu_time, folder, volume_of};
use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, SettingValue, decode_frame, encode_temporary};
use cvr_core::volume::{BrickSource as _, FiniteVolume, FrameIndex, NoReferences};
use cvr_vq::Vq;

/// Decibels by which a PSNR may lie below the peers'.
const TOLERANCE_DB: f64 = 0.2;

/// PSNR in dB over max − min of the original, integers rounded, and bits per sample of the whole file.
fn measured(name: &str, volume: &FiniteVolume, block: &str, more: &[(&str, &str)]) -> (f64, f64) {
    let mut settings = settings(more);
    settings.set("block", SettingValue::from(block));
    let begun = cpu_time();
    let stream = Arc::new(encode_temporary(&Vq, &settings, volume).unwrap());
    let seconds = (cpu_time() - begun).as_secs_f64();
    let layout = volume.layout();
    let rate = 8.0 * stream.file_bytes() as f64 / layout.samples() as f64;
    let (bound, training) =
        (stream.spec().report.error_bound.unwrap(), stream.spec().parameters["training"].clone());
    let decoder = Vq.decoder(stream).unwrap();
    let (mut square, mut worst) = (0.0, 0.0_f64);
    for frame in (0..layout.frames).map(FrameIndex) {
        let decoded = decode_frame(decoder.as_ref(), frame, &NoReferences).unwrap();
        for (d, s) in decoded.iter().zip(volume.dense().frame_values(frame)) {
            let shown = if layout.sample.is_integer() { d.round() } else { *d };
            let error = (f64::from(shown) - f64::from(s)).abs();
            square += error * error;
            worst = worst.max(error);
        }
    }
    assert_eq!(worst, bound, "{name}: the bound is the largest error that occurs");
    let psnr = 10.0 * (volume.range().span().powi(2) * layout.samples() as f64 / square).log10();
    let options: String = more.iter().map(|(name, value)| format!(" {name}={value}")).collect();
    println!(
        "| {name} | {block}³{options} | {rate:.4} | {psnr:.3} | {seconds:.2} | {} | {} |",
        training["blocks"][0], training["rounds"][0]
    );
    (psnr, rate)
}

/// 2³ and 4³ with 256 codewords, compared with PSNR and rate of the peers.
fn holds(name: &str, volume: &FiniteVolume, peers: [(f64, f64); 2]) {
    for (block, (psnr, rate)) in ["2", "4"].into_iter().zip(peers) {
        let (own, own_rate) = measured(name, volume, block, &[]);
        assert!(own >= psnr - TOLERANCE_DB, "{name} {block}³: {own} dB, the peers reach {psnr}");
        // The peers do not count headers. Our codewords have 8 bits, theirs 16.
        assert!(own_rate <= rate + 0.05, "{name} {block}³: {own_rate} bits, the peers' {rate}");
    }
}

#[test]
fn bonsai() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "bonsai");
    holds("bonsai", &volume, [(38.381, 1.002), (32.548, 0.141)]);
    let (more, _) = measured("bonsai", &volume, "4", &[("codewords", "4096")]);
    let (fewer, _) = measured("bonsai", &volume, "4", &[("codewords", "16")]);
    assert!(fewer < 32.548 && 32.548 < more);
}

#[test]
fn magnetic_resonance_head() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "mr_vs");
    holds("mr_vs", &volume, [(34.519, 1.002), (28.72, 0.140)]);
    measured("mr_vs", &volume, "2", &[("codeword_bits", "16")]);
}

#[test]
fn chest() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "lidc_chest");
    holds("lidc_chest", &volume, [(32.72, 1.011), (27.823, 0.158)]);
}

#[test]
fn vorticity() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "vorticity");
    holds("vorticity", &volume, [(39.622, 1.073), (35.364, 0.524)]);
}

#[test]
fn viscous_fingers() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "viscous_fingers");
    holds("viscous_fingers", &volume, [(40.063, 1.005), (36.208, 0.167)]);
    let shared = measured("viscous_fingers", &volume, "2", &[]);
    let each = measured("viscous_fingers", &volume, "2", &[("tables", "per-frame")]);
    assert!(each.0 > shared.0 && each.1 > shared.1, "a table per frame is better and larger");
}

#[test]
fn spin_labelling() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "pcasl");
    holds("pcasl", &volume, [(30.07, 1.046), (27.371, 0.496)]);
}

/// Not comparable with the peers, which code each channel separately with three times the bits.
#[test]
fn colours() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "dti_rgb");
    let (cubes_of_2, _) = measured("dti_rgb", &volume, "2", &[]);
    let (cubes_of_4, _) = measured("dti_rgb", &volume, "4", &[]);
    assert!(cubes_of_4 < cubes_of_2 && cubes_of_4 > 20.0, "{cubes_of_2} and {cubes_of_4} dB");
}
