//! Prints how the bits of a stream with the payload `fixed` are spent, and where its error lies.
//!
//! `CVR_DATA=folder cargo run --release -p cvr-tvq --example budget -- lidc_chest rate=0.7`
//!
//! Three tables: bits by part of the file; error by zone group after each stage; and other ways to code the same
//! volume: finer entries, no classes, more training blocks, and twice as many codewords in one codebook.

#![allow(clippy::unwrap_used, reason = "a program of figures, which any failure ends")]

use std::sync::Arc;

use cvr_codec_tests::real::{folder, volume_of};
use cvr_core::codec::{
    Codec, CodecInfo, ConfigError, DecodeError, Decoder, Encoder, SettingValue, Settings, decode_stages,
    encode_temporary,
};
use cvr_core::container::{Element, EncodedVolume};
use cvr_core::volume::{BrickSource as _, FiniteVolume, FrameIndex, NoReferences};
use cvr_tvq::inside::{Basis, Partition, Transform, encoder_of_sizes, energies, zones_of};
use cvr_tvq::{Parameters, Tvq};

/// Edge of a block.
const EDGE: usize = 4;
const VOXELS: usize = EDGE * EDGE * EDGE;
/// Zone groups: the mean, and the partitions.
const GROUPS: [&str; 4] = ["DC", "LP", "BP", "HP"];

/// The codec with codebooks of these sizes.
#[derive(Debug)]
struct OfSizes([usize; 3]);

impl Codec for OfSizes {
    fn info(&self) -> &CodecInfo {
        Tvq.info()
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        encoder_of_sizes(settings, self.0)
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Tvq.decoder(volume)
    }
}

/// How a stream spends its bits.
struct Spent {
    /// Bits of header and tables, codebooks, means, and the codes of each partition.
    bits: [f64; 6],
    /// Bits of a mean and of each partition's codes, in the first table.
    widths: [u32; 4],
    /// Codewords of each partition, the maximum over all tables.
    sizes: [usize; 3],
}

/// Number of blocks of each sub-volume of a plane, x fastest.
fn sub_volumes(parameters: &Parameters) -> Vec<f64> {
    let sub = if parameters.subvolume == 0 { u32::MAX } else { parameters.subvolume / EDGE as u32 };
    let lengths = parameters.grid.map(|n| (0..n).step_by(sub as usize).map(move |at| sub.min(n - at)));
    let [xs, ys, zs] = lengths.map(Iterator::collect::<Vec<u32>>);
    let rows = zs.iter().flat_map(|z| ys.iter().map(move |y| f64::from(y * z)));
    rows.flat_map(|area| xs.iter().map(move |x| area * f64::from(*x))).collect()
}

fn spent(stream: &EncodedVolume) -> Spent {
    let parameters: Parameters = stream.parameters().unwrap();
    let layout = &stream.spec().layout;
    let tables = stream.tensor("tables", Element::U32).unwrap();
    let subs = sub_volumes(&parameters);
    let planes = f64::from(layout.channels) * f64::from(layout.frames) / f64::from(parameters.tables);
    let mut spent = Spent { bits: [0.0; 6], widths: [0; 4], sizes: [1; 3] };
    for (t, table) in tables.words().chunks_exact(5 + 3 * parameters.books as usize).enumerate() {
        let blocks = subs[t % subs.len()] * planes;
        let widths = [table[1], table[7] & 31, table[10] & 31, table[13] & 31];
        if t == 0 {
            spent.widths = widths;
        }
        for (bits, width) in spent.bits[2..].iter_mut().zip(widths) {
            *bits += blocks * f64::from(width);
        }
        for (b, most) in spent.sizes.iter_mut().enumerate() {
            let size = table[6 + 3 * b];
            *most = (*most).max(size as usize);
            spent.bits[1] += f64::from(size * VOXELS as u32 * parameters.entry_bits);
        }
    }
    spent.bits[0] = 8.0 * stream.file_bytes() as f64 - spent.bits[1..].iter().sum::<f64>();
    spent
}

/// All blocks of some values, channel by channel. Values beyond the border are zero.
fn blocks(values: &[f64], extent: [usize; 3], channels: usize) -> Vec<f32> {
    let grid = extent.map(|e| e.div_ceil(EDGE));
    let mut blocks = vec![0.0; grid.iter().product::<usize>() * VOXELS * channels];
    for (i, value) in values.iter().enumerate() {
        let (voxel, channel) = (i / channels, i % channels);
        let p = [voxel % extent[0], voxel / extent[0] % extent[1], voxel / extent[0] / extent[1]];
        let of = |p: [usize; 3], size: [usize; 3]| p[0] + size[0] * (p[1] + size[1] * p[2]);
        let block = of(p.map(|p| p / EDGE), grid) + channel * grid.iter().product::<usize>();
        blocks[block * VOXELS + of(p.map(|p| p % EDGE), [EDGE; 3])] = *value as f32;
    }
    blocks
}

/// Squared error of each zone group after each stage: after the means, and after each partition.
fn errors(volume: &FiniteVolume, stream: &Arc<EncodedVolume>) -> [[f64; 4]; 4] {
    let layout = volume.layout();
    let (extent, channels) = (layout.extent.to_array().map(|e| e as usize), layout.channels as usize);
    let decoder = Tvq.decoder(Arc::clone(stream)).unwrap();
    let first: Vec<f64> = volume.dense().frame_values(FrameIndex::FIRST).into_iter().map(f64::from).collect();
    let basis = Basis::new(Transform::Klt, &blocks(&first, extent, channels));
    let mut all = [[0.0; 4]; 4];
    for frame in (0..layout.frames).map(FrameIndex) {
        let source: Vec<f64> = volume.dense().frame_values(frame).into_iter().map(f64::from).collect();
        for (stage, groups) in (1..).zip(&mut all) {
            let decoded = decode_stages(decoder.as_ref(), frame, stage, &NoReferences).unwrap();
            let shown = |d: f32| f64::from(if layout.sample.is_integer() { d.round() } else { d });
            let off: Vec<f64> = decoded.iter().zip(&source).map(|(d, s)| shown(*d) - s).collect();
            for block in blocks(&off, extent, channels).chunks_exact(VOXELS) {
                let zones = energies(&basis, block);
                groups[0] += block.iter().map(|v| f64::from(*v)).sum::<f64>().powi(2) / VOXELS as f64;
                for (group, partition) in groups[1..].iter_mut().zip(Partition::ALL) {
                    let within = |z: &usize| zones_of(partition) >> z & 1 == 1;
                    *group += (0..zones.len()).filter(within).map(|z| zones[z]).sum::<f64>();
                }
            }
        }
    }
    all
}

/// Bits per sample and PSNR in dB.
fn figures(volume: &FiniteVolume, stream: &Arc<EncodedVolume>) -> (f64, f64) {
    let layout = volume.layout();
    let decoder = Tvq.decoder(Arc::clone(stream)).unwrap();
    let frames = (0..layout.frames).map(FrameIndex);
    let decoded = frames.map(|f| decode_stages(decoder.as_ref(), f, u8::MAX, &NoReferences).unwrap());
    let error = cvr_core::metrics::VolumeError::compare(volume, decoded);
    (8.0 * stream.file_bytes() as f64 / layout.samples() as f64, error.psnr_db)
}

fn print_bits(samples: f64, spent: &Spent) {
    println!("\n| part | bits of a block | codewords | bits per sample | of all |\n|---|---|---|---|---|");
    let names = ["header and tables", "codebooks", "means", "LP codes", "BP codes", "HP codes"];
    let all: f64 = spent.bits.iter().sum();
    for (i, (name, bits)) in names.iter().zip(spent.bits).enumerate() {
        let width = i.checked_sub(2).map_or(String::new(), |w| spent.widths[w].to_string());
        let size = i.checked_sub(3).map_or(String::new(), |b| spent.sizes[b].to_string());
        println!("| {name} | {width} | {size} | {:.4} | {:.1} % |", bits / samples, 100.0 * bits / all);
    }
    println!("| all | | | {:.4} | |", all / samples);
}

fn print_errors(volume: &FiniteVolume, all: &[[f64; 4]; 4]) {
    let square = volume.range().span().powi(2) * volume.layout().samples() as f64;
    let decibels = |error: f64| 10.0 * (square / error).log10();
    println!("\n| zones | after the mean, dB | after LP, dB | after BP, dB | after HP, dB | of the error |");
    println!("|---|---|---|---|---|---|");
    let of_all = |stage: &[f64; 4]| stage.iter().sum::<f64>();
    for (g, name) in GROUPS.iter().enumerate() {
        let row: Vec<String> = all.iter().map(|stage| format!("{:.2}", decibels(stage[g]))).collect();
        println!("| {name} | {} | {:.1} % |", row.join(" | "), 100.0 * all[3][g] / of_all(&all[3]));
    }
    let row: Vec<String> = all.iter().map(|stage| format!("{:.2}", decibels(of_all(stage)))).collect();
    println!("| all | {} | |", row.join(" | "));
}

fn settings_of(pairs: &[(String, String)]) -> Settings {
    pairs.iter().map(|(name, value)| (name.clone(), SettingValue::from(value.as_str()))).collect()
}

fn main() {
    let Some(folder) = folder() else { return };
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "lidc_chest".to_owned());
    let mut given = vec![("payload".to_owned(), "fixed".to_owned())];
    for argument in arguments {
        let (name, value) = argument.split_once('=').unwrap();
        given.push((name.to_owned(), value.to_owned()));
    }
    let settings = settings_of(&given);
    let volume = volume_of(&folder, &name);
    let stream = Arc::new(encode_temporary(&Tvq, &settings, &volume).unwrap());
    let spent = spent(&stream);
    print_bits(volume.layout().samples() as f64, &spent);
    print_errors(&volume, &errors(&volume, &stream));
    println!("\n| coding | bits per sample | PSNR, dB | gain, dB |\n|---|---|---|---|");
    let (rate, before) = figures(&volume, &stream);
    println!("| as above | {rate:.4} | {before:.2} | |");
    let other = |what: &str, sizes: [usize; 3], pairs: &[(&str, &str)]| {
        let more = pairs.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
        let settings = settings_of(&given.iter().cloned().chain(more).collect::<Vec<_>>());
        let stream = Arc::new(encode_temporary(&OfSizes(sizes), &settings, &volume).unwrap());
        let (rate, psnr) = figures(&volume, &stream);
        println!("| {what} | {rate:.4} | {psnr:.2} | {:+.2} |", psnr - before);
    };
    other("entries of 16 bits", spent.sizes, &[("entry_bits", "16")]);
    other("no classes", spent.sizes, &[("classification", "false")]);
    other("trained on all blocks", spent.sizes, &[("training_blocks", "16777216")]);
    for (p, name) in GROUPS[1..].iter().enumerate() {
        let mut sizes = spent.sizes;
        sizes[p] *= 2;
        other(&format!("{name}: twice the codewords"), sizes, &[]);
    }
}
