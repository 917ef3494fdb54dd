//! PSNR and rate on real volumes, compared with peers. Endpoints of the peers' block code have as many bits as the
//! samples. Skips without `CVR_DATA`.
//!
//! The table of docs/benchmarks/bc4.md:
//! `CVR_DATA=folder cargo test --release -p cvr-bc4 --test bc4 real_volumes -- --nocapture --test-threads=1`

use std::sync::Arc;

use cvr_bc4::BC4;
use cvr_codec_tests::real::{cpu_time, folder, volume_of};
use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, decode_frame, encode_temporary};
use cvr_core::volume::{BrickSource as _, FiniteVolume, FrameIndex, NoReferences};

/// PSNR in dB over max − min of the original, integers rounded, and bits per sample of the whole file.
fn measured(name: &str, volume: &FiniteVolume, quality: &str) -> (f64, f64) {
    let begun = cpu_time();
    let stream = Arc::new(encode_temporary(&BC4, &settings(&[("quality", quality)]), volume).unwrap());
    let seconds = (cpu_time() - begun).as_secs_f64();
    let rate = 8.0 * stream.file_bytes() as f64 / volume.layout().samples() as f64;
    let bound = stream.spec().report.error_bound.unwrap();
    let decoder = BC4.decoder(stream).unwrap();
    let layout = volume.layout();
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
    println!("| {name} | {quality} | {rate:.4} | {psnr:.3} | {worst:.6} | {seconds:.2} |");
    (psnr, rate)
}

/// The search is better than the range, at the same rate. Returns its PSNR and rate.
fn searched(name: &str) -> Option<(f64, f64)> {
    let volume = volume_of(&folder()?, name);
    let [range, search] = ["range", "search"].map(|quality| measured(name, &volume, quality));
    assert!(search.0 > range.0, "{name}: {search:?} after the search, {range:?} without");
    Some(search)
}

/// At least the peers' PSNR, at no more than their bits, except for the header of a small file.
fn holds(name: &str, psnr: f64, bits: f64) {
    let Some((own, rate)) = searched(name) else { return };
    assert!(own >= psnr, "{name}: {own} dB, others reach {psnr}");
    assert!(rate <= bits, "{name}: {rate} bits, others take {bits}");
}

#[test]
fn bonsai() {
    holds("bonsai", 48.394, 4.002);
}

#[test]
fn magnetic_resonance_head() {
    holds("mr_vs", 47.083, 5.0);
}

#[test]
fn chest() {
    holds("lidc_chest", 46.267, 4.002);
}

#[test]
fn vorticity() {
    holds("vorticity", 52.773, 5.0);
}

#[test]
fn viscous_fingers() {
    holds("viscous_fingers", 51.042, 5.0);
}

#[test]
fn spin_labelling() {
    holds("pcasl", 41.342, 5.0);
}

/// Each channel has its own blocks.
#[test]
fn colours() {
    holds("dti_rgb", 43.679, 4.01);
}
