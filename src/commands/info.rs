//! `cvr info`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use cvr_core::codec::FrameStore;
use cvr_core::volume::{BrickSource, Replaced, VolumeLayout};

use super::histogram::bars;
use super::memory_args::MemoryArgs;
use super::opened::Opened;
use super::volume_args::{RawArgs, is_container};
use crate::exit::BadInput;
use crate::registry::Names;

const EXAMPLES: &str = "\
Examples:
  cvr info head.nrrd
  cvr info head.cvr
  cvr info flow.raw --dims 128x128x41 --dtype f32";

/// Arguments of `cvr info`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// A volume (a file of any format, a folder of slices, or a pattern like 'step*.raw' whose files are frames; the frames
    /// of several files follow each other), or a container (`.cvr`).
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    raw: RawArgs,
}

/// Prints the properties of a file.
///
/// # Errors
/// When it cannot be read.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    args.memory.allow();
    match &args.files[..] {
        [file] if is_container(file) => container(file)?,
        files => match files.iter().find(|f| is_container(f)) {
            Some(file) => {
                return Err(BadInput(format!(
                    "{} is encoded and no frame of a sequence: ask about it alone",
                    file.display()
                )));
            }
            None => volume(args)?,
        },
    }
    Ok(ExitCode::SUCCESS)
}

fn volume(args: &Args) -> Result<(), BadInput> {
    let loaded = args.raw.load_all(&args.files)?;
    layout(loaded.volume.layout());
    if !loaded.stored.is_kept_exactly() || loaded.stored.kept() != loaded.volume.layout().sample {
        say!("stored     {}, kept as {}", loaded.stored, loaded.volume.layout().sample);
    }
    let range = loaded.volume.range();
    say!("range      {} to {}", range.min, range.max);
    say!("histogram  |{}| (logarithmic)", bars(loaded.volume.dense().samples(), range));
    replaced(loaded.volume.replaced());
    say!("blake3     {}", loaded.provenance.blake3);
    Ok(())
}

/// Prints how many samples were replaced or rounded.
fn replaced(replaced: Replaced) {
    if replaced.total() > 0 {
        say!(
            "unusable   {} NaN, {} infinite, {} subnormal samples",
            replaced.nan,
            replaced.infinite,
            replaced.subnormal
        );
    }
    if replaced.rounded > 0 {
        say!("rounded    {} samples, to single precision", replaced.rounded);
    }
}

fn layout(layout: &VolumeLayout) {
    let [x, y, z] = layout.spacing;
    say!("dims       {}", layout.extent);
    say!("samples    {}, {} per voxel, {} frame(s)", layout.sample, layout.channels, layout.frames);
    say!("spacing    {x} {y} {z}");
    say!("bytes      {} uncompressed", layout.bytes());
}

fn container(file: &Path) -> Result<(), BadInput> {
    let Opened { stream, codec, decoder } = Opened::open(file, &Names::new()?, FrameStore::DEFAULT_MB)?;
    let spec = stream.spec();
    say!("codec      {} (stream version {})", spec.codec, spec.stream_version);
    say!("settings   {}", spec.settings);
    layout(decoder.layout());
    let resolutions = codec.resolutions(&spec.settings);
    if resolutions > 1 {
        say!("resolutions {resolutions}");
    }
    let bits = stream.file_bytes() as f64 * 8.0 / spec.layout.voxels() as f64;
    say!("file       {} bytes, {bits:.3} bits per voxel", stream.file_bytes());
    if let Some(bound) = spec.report.error_bound {
        say!("bound      no sample is off by more than {bound}");
    }
    replaced(spec.replaced);
    for note in &spec.report.notes {
        say!("note       {note}");
    }
    for (name, tensor) in &spec.tensors {
        say!("tensor     {name}: {} {:?}, crc32c {:08x}", tensor.element.name(), tensor.shape, tensor.crc32c);
    }
    Ok(())
}
