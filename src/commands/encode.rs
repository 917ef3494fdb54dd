//! `cvr encode`

use std::path::PathBuf;
use std::process::ExitCode;

use cvr_core::codec::encode_file;
use cvr_core::volume::BrickSource;

use super::memory_args::MemoryArgs;
use super::output::Output;
use super::settings_args::settings;
use super::volume_args::{RawArgs, check_output};
use crate::exit::BadInput;
use crate::progress::VoxelBar;
use crate::registry::Names;

const EXAMPLES: &str = "\
Examples:
  cvr encode head.nrrd head.cvr --codec s3dc --set block=8 --set index_bits=4
  cvr encode head.nrrd head.cvr --codec tvq --set payload=variable --set rate=0.5
  cvr encode flow.raw flow.cvr --codec vq --dims 128x128x41 --dtype f32";

/// Arguments of `cvr encode`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The volume: a file of any format, a folder of slices, or a pattern like 'step*.raw' whose files are frames.
    volume: PathBuf,
    #[arg(help = Output::help(&[Output::Container]))]
    out: PathBuf,
    /// Codec id; see `cvr codecs`.
    #[arg(long)]
    codec: String,
    /// A setting of the codec.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    raw: RawArgs,
}

/// Encodes a volume.
///
/// # Errors
/// When arguments, volume or output are unusable.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    args.memory.allow();
    let names = Names::new()?;
    let codec = names.codecs().get(&args.codec)?;
    let settings = settings(codec.info(), &args.set)?;
    check_output(&args.out, &args.volume)?;
    Output::of(&args.out, &[Output::Container])?;
    let volume = args.raw.load(&args.volume)?.volume;
    let bar = VoxelBar::new(volume.layout().voxels());
    let written =
        encode_file(codec.as_ref(), &settings, &volume, volume.replaced(), &args.out, &bar.progress())?;
    bar.finish();
    let bits = written.file_bytes as f64 * 8.0 / volume.layout().voxels() as f64;
    say!("{}: {} bytes, {bits:.3} bits per voxel", args.out.display(), written.file_bytes);
    if volume.replaced().total() > 0 {
        say!("{} samples were no usable numbers and were replaced", volume.replaced().total());
    }
    if volume.replaced().rounded > 0 {
        say!("{} samples were rounded to single precision", volume.replaced().rounded);
    }
    Ok(ExitCode::SUCCESS)
}
