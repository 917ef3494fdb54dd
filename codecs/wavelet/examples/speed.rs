//! Seconds and PSNR of encoding and decoding real volumes, step by step.
//!
//! `CVR_DATA=folder cargo run --release -p cvr-wavelet --example speed -- bonsai,mr_vs bits_per_voxel=0.5 filter=haar`
//!
//! Times are those of the library's calls: from a volume in memory to a stream in a file, and from a stream in memory to
//! samples. `RAYON_NUM_THREADS` sets the number of threads. The best of five runs counts.

#![allow(clippy::unwrap_used, reason = "a program of figures, which any failure ends")]

use std::sync::Arc;
use std::time::Instant;

use cvr_codec_tests::real::{folder, volume_of};
use cvr_core::codec::{Codec as _, SettingValue, Settings, decode_frame, encode_temporary};
use cvr_core::metrics::VolumeError;
use cvr_core::volume::{BrickSource as _, FrameIndex, NoReferences};
use cvr_wavelet::Wavelet;

/// The least seconds of five calls, and the last result.
fn best<T>(mut call: impl FnMut() -> T) -> (f64, T) {
    let mut timed = || {
        let begun = Instant::now();
        let result = call();
        (begun.elapsed().as_secs_f64(), result)
    };
    let mut best = timed();
    for _ in 1..5 {
        let (seconds, result) = timed();
        best = (best.0.min(seconds), result);
    }
    best
}

fn main() {
    let Some(folder) = folder() else { return };
    let mut arguments = std::env::args().skip(1);
    let names = arguments.next().unwrap_or_else(|| "bonsai".to_owned());
    let pairs =
        arguments.map(|a| a.split_once('=').map(|(n, v)| (n.to_owned(), SettingValue::from(v))).unwrap());
    let settings: Settings = pairs.collect();
    println!(
        "| volume | settings | bits per voxel | PSNR dB | encode s | decode s |\n|---|---|---|---|---|---|"
    );
    for name in names.split(',') {
        let volume = volume_of(&folder, name);
        let layout = volume.layout().clone();
        let (encode, stream) = best(|| Arc::new(encode_temporary(&Wavelet, &settings, &volume).unwrap()));
        let (decode, decoded) = best(|| {
            let decoder = Wavelet.decoder(Arc::clone(&stream)).unwrap();
            let frames = (0..layout.frames).map(FrameIndex);
            frames.map(|f| decode_frame(decoder.as_ref(), f, &NoReferences).unwrap()).collect::<Vec<_>>()
        });
        let bits =
            8.0 * stream.file_bytes() as f64 / (layout.extent.voxels() as f64 * f64::from(layout.frames));
        let psnr = VolumeError::compare(&volume, decoded).psnr_db;
        println!("| {name} | {settings} | {bits:.4} | {psnr:.3} | {encode:.3} | {decode:.3} |");
    }
}
