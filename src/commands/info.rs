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
        say!("range      {} to {}", range.min, range.max);
        let replaced = loaded.volume.replaced();
        if replaced.total() > 0 {
            say!(
                "unusable   {} NaN, {} infinite, {} subnormal samples",
                replaced.nan,
                replaced.infinite,
                replaced.subnormal
            );
        }
        say!("blake3     {}", loaded.provenance.blake3);
    }
    Ok(ExitCode::SUCCESS)
}

fn layout(layout: &VolumeLayout) {
    let [x, y, z] = layout.spacing;
    say!("dims       {}", layout.extent);
    say!("samples    {}, {} per voxel, {} frame(s)", layout.sample, layout.channels, layout.frames);
    say!("spacing    {x} {y} {z}");
    say!("bytes      {} uncompressed", layout.bytes());
}

fn container(args: &Args) -> Result<(), BadInput> {
    let Opened { stream, decoder, .. } = Opened::open(&args.file, &Names::new()?)?;
    let spec = stream.spec();
    say!("codec      {} (stream version {})", spec.codec, spec.stream_version);
    say!("settings   {}", spec.settings);
    layout(decoder.layout());
    let bits = stream.file_bytes() as f64 * 8.0 / spec.layout.voxels() as f64;
    say!("file       {} bytes, {bits:.3} bits per voxel", stream.file_bytes());
    if let Some(bound) = spec.report.error_bound {
        say!("bound      no sample is off by more than {bound}");
    }
    for note in &spec.report.notes {
        say!("note       {note}");
    }
    for (name, tensor) in &spec.tensors {
        say!("tensor     {name}: {} {:?}, crc32c {:08x}", tensor.element.name(), tensor.shape, tensor.crc32c);
    }
    Ok(())
}
