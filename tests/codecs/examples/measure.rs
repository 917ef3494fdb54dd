//! PSNR over total bits per sample of real volumes, and the time and memory of encoding.
//!
//! `CVR_DATA=folder cargo run --release -p cvr-codec-tests --example measure -- tvq bonsai,mr_vs payload=fixed rate=0.4,0.75`
//!
//! A setting with several values, separated by commas, is tried with each. `bonsai@64` is the central cube of 64³
//! voxels of bonsai; with it, time can be compared for different sizes. `sheet@48` are the volumes of the stability
//! atlas with that name and edge, at every dial step. `atlas@48` are all of them. Memory is the maximum of this process
//! so far (Linux).

#![allow(clippy::unwrap_used, reason = "a program of figures, which any failure ends")]

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use cvr_codec_tests::real::{NAMES, cpu_time, folder, volume_of};
use cvr_core::codec::{Codec, SettingValue, Settings, decode_frame, encode_temporary};
use cvr_core::stability::Subject;
use cvr_core::volume::{
    BrickSource as _, DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, Region, SampleType,
    Samples, VolumeLayout,
};

/// Peak memory of this process in MiB. 0 if the system does not report it.
fn peak_mib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok()).unwrap_or(0) / 1024
}

/// The central cube of `edge` voxels of a scalar volume of bytes.
fn middle(volume: &FiniteVolume, edge: u32) -> FiniteVolume {
    let extent = volume.layout().extent.to_array();
    let origin = extent.map(|e| (e - edge) / 2);
    let region = Region { origin, extent: Extent::cube(edge).unwrap() };
    let mut values = vec![0.0; region.extent.voxels() as usize];
    volume.read(FrameIndex::FIRST, region, &mut values).unwrap();
    let samples = Samples::U8(values.iter().map(|v| *v as u8).collect());
    let layout = VolumeLayout::scalar(region.extent, SampleType::U8);
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

/// The volumes of a name on the command line, with their own names.
fn volumes(folder: &Path, name: &str) -> Vec<(String, FiniteVolume)> {
    let Some((whole, edge)) = name.split_once('@') else {
        return vec![(name.to_owned(), volume_of(folder, name))];
    };
    let edge = edge.parse().unwrap();
    let subjects: Vec<_> = Subject::all().filter(|s| whole == "atlas" || s.name == whole).collect();
    if subjects.is_empty() {
        return vec![(name.to_owned(), middle(&volume_of(folder, whole), edge))];
    }
    let steps = |subject: &'static Subject| {
        let of_step = move |(i, step)| (format!("{} {step}", subject.name), subject.volume(i, edge));
        subject.steps.iter().enumerate().map(of_step)
    };
    subjects.into_iter().flat_map(steps).collect()
}

/// Prints PSNR in dB and bits per sample of the whole file as a row.
fn measure(codec: &dyn Codec, name: &str, volume: &FiniteVolume, pairs: &[(String, String)], verbose: bool) {
    let settings: Settings =
        pairs.iter().map(|(name, value)| (name.clone(), SettingValue::from(value.as_str()))).collect();
    let (begun, wall) = (cpu_time(), Instant::now());
    let stream = Arc::new(encode_temporary(codec, &settings, volume).unwrap());
    let (seconds, wall) = ((cpu_time() - begun).as_secs_f64(), wall.elapsed().as_secs_f64());
    let peak = peak_mib();
    let layout = volume.layout();
    let rate = 8.0 * stream.file_bytes() as f64 / layout.samples() as f64;
    let decoder = codec.decoder(Arc::clone(&stream)).unwrap();
    let mut square = 0.0;
    for frame in (0..layout.frames).map(FrameIndex) {
        let decoded = decode_frame(decoder.as_ref(), frame, &NoReferences).unwrap();
        for (d, s) in decoded.iter().zip(volume.dense().frame_values(frame)) {
            let shown = if layout.sample.is_integer() { d.round() } else { *d };
            square += (f64::from(shown) - f64::from(s)).powi(2);
        }
    }
    let psnr = 10.0 * (volume.range().span().powi(2) * layout.samples() as f64 / square).log10();
    let options: Vec<String> = pairs.iter().map(|(name, value)| format!("{name}={value}")).collect();
    println!(
        "| {name} | {} | {rate:.4} | {psnr:.3} | {seconds:.1} | {wall:.1} | {peak} |",
        options.join(" ")
    );
    if verbose {
        println!("  {:?} {}", stream.spec().report, stream.spec().parameters["training"]);
    }
}

/// The codecs with settings of their own.
fn codecs() -> [Arc<dyn Codec>; 8] {
    [
        cvr_bc4::codec(),
        cvr_hvq::codec(),
        cvr_rvq::codec(),
        cvr_s3dc::codec(),
        cvr_tvq::codec(),
        cvr_vq::codec(),
        cvr_wavelet::codec(),
        cvr_zfp::codec(),
    ]
}

fn main() {
    let Some(folder) = folder() else { return };
    let mut arguments = std::env::args().skip(1).peekable();
    let id = arguments.next().unwrap_or_default();
    let Some(codec) = codecs().into_iter().find(|codec| codec.info().id == id) else {
        let known: Vec<&str> = codecs().iter().map(|codec| codec.info().id).collect();
        println!("usage: measure CODEC [VOLUMES [-v] [SETTING=VALUE,...]...]; codecs: {}", known.join(", "));
        return;
    };
    let names = arguments.next().unwrap_or_else(|| NAMES.join(","));
    let verbose = arguments.next_if(|a| a == "-v").is_some();
    let mut all: Vec<Vec<(String, String)>> = vec![Vec::new()];
    for argument in arguments {
        let (name, values) = argument.split_once('=').unwrap();
        let with = |pairs: &Vec<(String, String)>| -> Vec<Vec<(String, String)>> {
            let one = |v: &str| [&pairs[..], &[(name.to_owned(), v.to_owned())]].concat();
            values.split(',').map(one).collect()
        };
        all = all.iter().flat_map(with).collect();
    }
    println!(
        "| volume | settings | bits per sample | PSNR dB | CPU s | wall s | peak MiB |\n|---|---|---|---|---|---|---|"
    );
    for name in names.split(',') {
        for (name, volume) in volumes(&folder, name) {
            all.iter().for_each(|pairs| measure(codec.as_ref(), &name, &volume, pairs, verbose));
        }
    }
}
