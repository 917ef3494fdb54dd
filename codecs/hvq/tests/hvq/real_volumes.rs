//! PSNR and rate on real volumes, compared with HVQ by k-means of FAISS as peers measured it. Skips without `CVR_DATA`.
//!
//! The table of docs/benchmarks/hvq.md:
//! `CVR_DATA=folder cargo test --release -p cvr-hvq --test hvq real_volumes -- --nocapture --test-threads=1`

use std::sync::Arc;

use cvr_codec_tests::real::{cpu_time, folder, volume_of};
use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, Decoder, decode_stages, encode_temporary};
use cvr_core::volume::{BrickSource as _, FiniteVolume, FrameIndex, NoReferences};
use cvr_hvq::Hvq;

/// PSNR in dB over max − min of the original, integers rounded, with this number of stages, and the largest error.
fn psnr(volume: &FiniteVolume, decoder: &dyn Decoder, stages: u8) -> (f64, f64) {
    let layout = volume.layout();
    let (mut square, mut worst) = (0.0, 0.0_f64);
    for frame in (0..layout.frames).map(FrameIndex) {
        let decoded = decode_stages(decoder, frame, stages, &NoReferences).unwrap();
        for (d, s) in decoded.iter().zip(volume.dense().frame_values(frame)) {
            let shown = if layout.sample.is_integer() { d.round() } else { *d };
            let error = (f64::from(shown) - f64::from(s)).abs();
            square += error * error;
            worst = worst.max(error);
        }
    }
    (10.0 * (volume.range().span().powi(2) * layout.samples() as f64 / square).log10(), worst)
}

/// PSNR of all stages, and bits per sample of the whole file.
fn measured(name: &str, volume: &FiniteVolume, options: &[(&str, &str)]) -> (f64, f64) {
    let settings = settings(options);
    let begun = cpu_time();
    let stream = Arc::new(encode_temporary(&Hvq, &settings, volume).unwrap());
    let seconds = (cpu_time() - begun).as_secs_f64();
    let rate = 8.0 * stream.file_bytes() as f64 / volume.layout().samples() as f64;
    let (bound, training) =
        (stream.spec().report.error_bound.unwrap(), stream.spec().parameters["training"].clone());
    let decoder = Hvq.decoder(stream).unwrap();
    let levels = [1, 2, 3].map(|stages| psnr(volume, decoder.as_ref(), stages));
    assert_eq!(levels[2].1, bound, "{name}: the bound is the largest error that occurs");
    assert!(levels.is_sorted_by(|a, b| a.0 <= b.0), "{name}: {levels:?}");
    let options: String = options.iter().map(|(name, value)| format!(" {name}={value}")).collect();
    println!(
        "| {name} | {} | {rate:.4} | {:.3} | {:.3} | {:.3} | {seconds:.2} | {} | {} {} |",
        options.trim(),
        levels[0].0,
        levels[1].0,
        levels[2].0,
        training["blocks"][0],
        training["coarse"]["rounds"][0],
        training["detail"]["rounds"][0],
    );
    (levels[2].0, rate)
}

/// At least the PSNR of the peers, at no more bits.
fn holds(name: &str, volume: &FiniteVolume, options: &[(&str, &str)], (psnr, rate): (f64, f64)) {
    let (own, own_rate) = measured(name, volume, options);
    assert!(own >= psnr, "{name}: {own} dB, the peers reach {psnr}");
    assert!(own_rate <= rate, "{name}: {own_rate} bits, the peers' {rate}");
}

/// Means of 8 bits. The peers use them for samples of any depth.
const PEERS: &[(&str, &str)] = &[("mean_bits", "8")];

#[test]
fn bonsai() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "bonsai");
    holds("bonsai", &volume, &[], (35.478, 0.39258));
    for init in ["pnn", "random"] {
        measured("bonsai", &volume, &[("init", init)]);
    }
    measured("bonsai", &volume, &[("coarse_codewords", "16"), ("detail_codewords", "4096")]);
    let mut before = 0.0;
    for codewords in ["16", "64", "1024", "4096"] {
        let (psnr, _) =
            measured("bonsai", &volume, &[("coarse_codewords", codewords), ("detail_codewords", codewords)]);
        assert!(psnr > before, "more codewords are better");
        before = psnr;
    }
}

#[test]
fn magnetic_resonance_head() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "mr_vs");
    holds("mr_vs", &volume, PEERS, (31.684, 0.39178));
    measured("mr_vs", &volume, &[]);
}

#[test]
fn chest() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "lidc_chest");
    holds("lidc_chest", &volume, &[], (30.033, 0.41729));
}

#[test]
fn vorticity() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "vorticity");
    holds("vorticity", &volume, PEERS, (38.105, 0.84146));
    measured("vorticity", &volume, &[]);
}

#[test]
fn viscous_fingers() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "viscous_fingers");
    holds("viscous_fingers", &volume, PEERS, (40.903, 0.42188));
    let shared = measured("viscous_fingers", &volume, &[]);
    let each = measured("viscous_fingers", &volume, &[("tables", "per-frame")]);
    assert!(each.0 > shared.0 && each.1 > shared.1, "a table per frame is better and larger");
}

#[test]
fn spin_labelling() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "pcasl");
    holds("pcasl", &volume, PEERS, (29.249, 0.79201));
    measured("pcasl", &volume, &[]);
}

/// The peers code each channel separately, with its own indices.
#[test]
fn colours() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "dti_rgb");
    measured("dti_rgb", &volume, &[]);
    // 8640 blocks: codebooks are as large as indices, and the first codebook matters.
    holds("dti_rgb", &volume, &[("coarse_codewords", "512"), ("init", "pnn")], (27.744, 0.55278));
}
