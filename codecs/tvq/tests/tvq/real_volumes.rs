//! PSNR and rate on real volumes, compared with HVQ and with KLT plus k-means, as peers measured them. Skips without
//! `CVR_DATA`. `examples/measure.rs` prints the figures of docs/benchmarks/tvq.md. This test checks some of them.

use std::sync::Arc;

use cvr_codec_tests::real::{folder, volume_of};
use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, decode_frame, encode_temporary};
use cvr_core::metrics::VolumeError;
use cvr_core::volume::{BrickSource as _, FiniteVolume, FrameIndex, NoReferences};
use cvr_tvq::Tvq;

/// PSNR, and bits per sample of the whole file.
fn measured(volume: &FiniteVolume, payload: &str, rate: &str) -> (f64, f64) {
    let settings = settings(&[("payload", payload), ("rate", rate)]);
    let stream = Arc::new(encode_temporary(&Tvq, &settings, volume).unwrap());
    let bits = 8.0 * stream.file_bytes() as f64 / volume.layout().samples() as f64;
    let decoder = Tvq.decoder(stream).unwrap();
    let frames = (0..volume.layout().frames).map(FrameIndex);
    let decoded = frames.map(|frame| decode_frame(decoder.as_ref(), frame, &NoReferences).unwrap());
    (VolumeError::compare(volume, decoded).psnr_db, bits)
}

/// At least this PSNR, with at most `rate` bits per sample.
fn reaches(name: &str, volume: &FiniteVolume, payload: &str, rate: &str, least: f64) {
    let (psnr, bits) = measured(volume, payload, rate);
    println!(
        "{name} {payload}: {psnr:.2} dB at {bits:.4} bits per sample; {least} at {rate} are to be reached"
    );
    assert!(psnr >= least, "{name} {payload} at {rate}: {psnr} dB, at least {least}");
    assert!(bits <= rate.parse().unwrap(), "{name} {payload}: {bits} bits per sample of {rate}");
}

/// Compared with HVQ and, at three quarters of the bits, with KLT and k-means of the peers.
#[test]
fn flat_blocks_cost_little_under_variable() {
    let Some(folder) = folder() else { return };
    for (name, rate, [hvq, klt]) in
        [("bonsai", "0.3925", [35.478, 35.906]), ("lidc_chest", "0.4172", [30.033, 30.725])]
    {
        let volume = volume_of(&folder, name);
        reaches(name, &volume, "fixed", rate, hvq);
        reaches(name, &volume, "variable", rate, f64::max(hvq + 2.0, klt + 1.0));
    }
}

/// Most of lidc_chest's energy lies in few blocks. One codebook of thousands of codewords, trained on as many blocks as
/// there are, serves it better than three of a hundred.
#[test]
fn one_large_codebook_is_found_where_it_serves_best() {
    let Some(folder) = folder() else { return };
    // The rate of HVQ with 256 and 1024 codewords, and its PSNR.
    reaches("lidc_chest", &volume_of(&folder, "lidc_chest"), "fixed", "0.4793", 31.708 + 0.5);
}

#[test]
fn busy_volumes_gain_least() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "vorticity");
    reaches("vorticity", &volume, "fixed", "0.8414", 38.11);
    reaches("vorticity", &volume, "variable", "0.8414", 38.11 + 1.0);
}

/// Blocks that repeat in every frame: few codebooks, of sizes that fit the rate.
#[test]
fn few_blocks_have_codebooks_of_sizes_that_fit() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "pcasl");
    let (fixed, _) = measured(&volume, "fixed", "1");
    reaches("pcasl", &volume, "variable", "1", fixed + 2.0);
    reaches("pcasl", &volume, "variable", "0.65", 36.0);
    // The PSNR of HVQ with 256 and 1024 codewords.
    reaches("pcasl", &volume, "fixed", "1.1949", 49.07);
}
