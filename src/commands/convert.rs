//! `cvr convert`

use std::path::PathBuf;
use std::process::ExitCode;

use cvr_core::volume::BrickSource;

use super::memory_args::MemoryArgs;
use super::output::Output;
use super::volume_args::{RawArgs, check_output, is_container};
use super::volume_output::{not_held, write_volume};
use crate::exit::BadInput;

const EXAMPLES: &str = "\
Examples:
  cvr convert head.nii.gz head.nrrd
  cvr convert slices/ head.npy
  cvr convert flow.raw flow.nrrd --dims 128x128x41 --dtype f32";

/// Arguments of `cvr convert`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The volume: a file of any format, a folder of slices, or a pattern like 'step*.raw' whose files are frames. The frames
    /// of several files follow each other. The last path is the file to write.
    #[arg(required = true, num_args = 1.., value_name = "IN")]
    files: Vec<PathBuf>,
    #[arg(help = Output::help(Output::VOLUMES))]
    out: PathBuf,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    raw: RawArgs,
}

/// Writes a volume in another format, with its channels and frames.
///
/// # Errors
/// When arguments, volume or output are unusable.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    args.memory.allow();
    let format = Output::of(&args.out, Output::VOLUMES)?;
    for file in &args.raw.found(&args.files)? {
        check_output(&args.out, file)?;
        if is_container(file) {
            return Err(BadInput(format!("{} is encoded: use `cvr decode`", file.display())));
        }
    }
    let input = args.raw.read_all(&args.files)?;
    let layout = input.volume.layout();
    write_volume(&args.out, format, &input.volume)?;
    say!(
        "{}: {} of {}, {} per voxel, {} frame(s)",
        args.out.display(),
        layout.extent,
        layout.sample,
        layout.channels,
        layout.frames
    );
    if let Some(words) = not_held(format, layout) {
        say!("{words}");
    }
    if input.rounded > 0 {
        say!("{} samples of {} were rounded to single precision", input.rounded, input.stored);
    }
    Ok(ExitCode::SUCCESS)
}
