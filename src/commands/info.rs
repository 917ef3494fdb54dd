//! `cvr info`

use std::path::PathBuf;
use std::process::ExitCode;

use cvr_core::volume::{BrickSource, VolumeLayout};

use super::opened::Opened;
use super::volume_args::{RawArgs, is_container};
use crate::exit::BadInput;
use crate::registry::Names;

/// Arguments of `cvr info`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A volume or a container (`.cvr`).
    file: PathBuf,
    #[command(flatten)]
    raw: RawArgs,
}

/// Says what a file is.
///
/// # Errors
/// When it cannot be read.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    if is_container(&args.file) {
        container(args)?;
    } else {
        let loaded = args.raw.load(&args.file)?;
        layout(loaded.volume.layout());
        let range = loaded.volume.range();
        println!("range      {} to {}", range.min, range.max);
        let replaced = loaded.volume.replaced();
        if replaced.total() > 0 {
            println!(
                "unusable   {} NaN, {} infinite, {} subnormal samples",
                replaced.nan, replaced.infinite, replaced.subnormal
            );
        }
        println!("blake3     {}", loaded.provenance.blake3);
    }
    Ok(ExitCode::SUCCESS)
}

fn layout(layout: &VolumeLayout) {
    let [x, y, z] = layout.spacing;
    println!("dims       {}", layout.extent);
    println!("samples    {}, {} per voxel, {} frame(s)", layout.sample, layout.channels, layout.frames);
    println!("spacing    {x} {y} {z}");
    println!("bytes      {} uncompressed", layout.bytes());
}

fn container(args: &Args) -> Result<(), BadInput> {
    let Opened { stream, decoder, .. } = Opened::open(&args.file, &Names::new()?)?;
    let spec = stream.spec();
    println!("codec      {} (stream version {})", spec.codec, spec.stream_version);
    println!("settings   {}", spec.settings);
    layout(decoder.layout());
    let bits = stream.file_bytes() as f64 * 8.0 / spec.layout.voxels() as f64;
    println!("file       {} bytes, {bits:.3} bits per voxel", stream.file_bytes());
    if let Some(bound) = spec.report.error_bound {
        println!("bound      no sample is off by more than {bound}");
    }
    for note in &spec.report.notes {
        println!("note       {note}");
    }
    for (name, tensor) in &spec.tensors {
        println!(
            "tensor     {name}: {} {:?}, crc32c {:08x}",
            tensor.element.name(),
            tensor.shape,
            tensor.crc32c
        );
    }
    Ok(())
}
