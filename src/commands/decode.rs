//! `cvr decode`

use std::path::PathBuf;
use std::process::ExitCode;

use cvr_core::codec::decode_stages;
use cvr_core::volume::{DenseVolume, FrameIndex, NoReferences, SampleType, Samples};

use super::opened::{LevelArgs, Opened};
use super::output::Output;
use super::volume_args::check_output;
use super::volume_output::{not_held, write_volume};
use crate::exit::BadInput;
use crate::registry::Names;

const EXAMPLES: &str = "\
Examples:
  cvr decode head.cvr head.nrrd
  cvr decode head.cvr coarse.npy --stages 1";

/// Arguments of `cvr decode`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The container.
    container: PathBuf,
    #[arg(help = Output::help(Output::VOLUMES))]
    out: PathBuf,
    /// Write decoded values as they are, not rounded to the original's integers.
    #[arg(long)]
    float: bool,
    #[command(flatten)]
    level: LevelArgs,
}

/// Decodes a container.
///
/// # Errors
/// When arguments, container or output are unusable.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    check_output(&args.out, &args.container)?;
    let format = Output::of(&args.out, Output::VOLUMES)?;
    let opened = Opened::open(&args.container, &Names::new()?)?;
    let stages = args.level.of(opened.codec.as_ref(), &opened.stream.spec().settings)?.stages;
    let mut layout = opened.decoder.layout().clone();
    let mut values = Vec::new();
    for frame in (0..layout.frames).map(FrameIndex) {
        values.append(&mut decode_stages(opened.decoder.as_ref(), frame, stages, &NoReferences)?);
    }
    if args.float {
        layout.sample = SampleType::F32;
    }
    let volume = DenseVolume::new(layout.clone(), to_samples(layout.sample, values)).map_err(BadInput)?;
    write_volume(&args.out, format, &volume)?;
    say!("{}: {} voxels of {}", args.out.display(), layout.extent, layout.sample);
    if let Some(words) = not_held(format, &volume) {
        say!("{words}");
    }
    Ok(ExitCode::SUCCESS)
}

/// Values rounded and clamped to a number type.
fn to_samples(sample: SampleType, values: Vec<f32>) -> Samples {
    // A cast from float to integer saturates, which is the clamp that is wanted.
    match sample {
        SampleType::U8 => Samples::U8(values.iter().map(|v| v.round() as u8).collect()),
        SampleType::I8 => Samples::I8(values.iter().map(|v| v.round() as i8).collect()),
        SampleType::U16 => Samples::U16(values.iter().map(|v| v.round() as u16).collect()),
        SampleType::I16 => Samples::I16(values.iter().map(|v| v.round() as i16).collect()),
        _ => Samples::F32(values),
    }
}
