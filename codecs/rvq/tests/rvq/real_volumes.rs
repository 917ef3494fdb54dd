//! PSNR on real volumes against residual quantisers of FAISS, as others measured them. Skips without `CVR_DATA`.
//! More figures: docs/benchmarks/rvq.md.

use std::sync::Arc;

use cvr_codec_tests::real::{folder, volume_of};
use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, decode_frame, encode_temporary};
use cvr_core::volume::{BrickSource as _, FrameIndex, NoReferences};
use cvr_rvq::Rvq;

/// PSNR in dB over max − min of the original, integers rounded, and bits of codes per sample.
fn measured(name: &str, pairs: &[(&str, &str)]) -> Option<(f64, f64)> {
    let volume = volume_of(&folder()?, name);
    let stream = Arc::new(encode_temporary(&Rvq, &settings(pairs), &volume).unwrap());
    let layout = volume.layout();
    let bound = stream.spec().report.error_bound.unwrap();
    let index = stream.tensor("index", cvr_core::container::Element::U32).unwrap().words().len();
    let decoder = Rvq.decoder(stream).unwrap();
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
    let samples = layout.samples() as f64;
    Some((10.0 * (volume.range().span().powi(2) * samples / square).log10(), 32.0 * index as f64 / samples))
}

/// Greedy stages of 256 codewords in 16 bits reach what FAISS's do, with codes of as many bits.
fn reaches(name: &str, stages: &str, (bits, psnr): (f64, f64)) {
    let greedy = [("codewords", "256"), ("entries", "16"), ("beam", "1"), ("refinement", "0")];
    let Some((own, own_bits)) = measured(name, &[&greedy[..], &[("stages", stages)]].concat()) else {
        return;
    };
    println!("{name} {stages} × 256: {own:.3} dB at {own_bits:.3} bits of codes, FAISS {psnr} at {bits}");
    assert!(own >= psnr, "{name}: {own} dB, FAISS reaches {psnr}");
    assert!(own_bits <= bits + 0.001, "{name}: {own_bits} bits, FAISS's {bits}");
}

#[test]
fn bonsai() {
    reaches("bonsai", "4", (0.5, 39.744));
}

#[test]
fn chest() {
    reaches("lidc_chest", "4", (0.511, 32.696));
}

#[test]
fn vorticity() {
    reaches("vorticity", "8", (1.073, 46.866));
}

#[test]
fn viscous_fingers() {
    reaches("viscous_fingers", "4", (0.5, 48.929));
}

#[test]
fn spin_labelling() {
    reaches("pcasl", "8", (1.0, 51.215));
}

/// As many codes as pay, and escapes, at half a bit in all: 39.4 dB of `tvq` before it had escapes.
#[test]
fn chest_at_half_a_bit() {
    let pairs = [("payload", "variable"), ("rate", "0.5"), ("beam", "1"), ("training_blocks", "32768")];
    let Some((own, bits)) = measured("lidc_chest", &pairs) else { return };
    println!("lidc_chest variable: {own:.3} dB, {bits:.3} bits of groups without heads and codebooks");
    assert!(own >= 41.5 && bits < 0.5, "{own} dB at {bits}");
}

/// FAISS's codes of each colour take 2.4 bits for 57 dB; here nothing is lost.
#[test]
fn colours_without_loss() {
    let pairs = [("payload", "variable"), ("rate", "2.4"), ("beam", "1")];
    let Some((own, bits)) = measured("dti_rgb", &pairs) else { return };
    println!("dti_rgb variable: {own:.3} dB, {bits:.3} bits of groups without heads and codebooks");
    assert!(own == f64::INFINITY && bits < 2.4, "{own} dB at {bits}");
}

/// One codebook for blocks of three colours; FAISS codes each colour by itself, with as many bits.
#[test]
fn colours() {
    let Some((own, bits)) = measured("dti_rgb", &[("stages", "12"), ("codewords", "256")]) else { return };
    println!("dti_rgb 12 × 256: {own:.3} dB at {bits:.3} bits of codes");
    assert!(own >= 30.62 && bits <= 0.501, "{own} dB at {bits} bits");
}
