//! `cvr decode`

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use cvr_core::codec::{DecodeError, Decoder, decode_pieces};
use cvr_core::memory::gigabytes;
use cvr_core::volume::{FrameIndex, Level, SampleType, Samples, VolumeLayout};

use super::memory_args::MemoryArgs;
use super::opened::{DecodedFramesArgs, LevelArgs, Opened};
use super::output::Output;
use super::volume_args::check_output;
use super::volume_output::{not_held, write_volume_from};
use crate::exit::BadInput;
use crate::input::MAX_VOLUME_BYTES;
use crate::registry::Names;

const EXAMPLES: &str = "\
Examples:
  cvr decode head.cvr head.nrrd
  cvr decode head.cvr coarse.npy --stages 1
  cvr decode head.cvr small.nrrd --resolution 2";

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
    #[command(flatten)]
    frames: DecodedFramesArgs,
    #[command(flatten)]
    memory: MemoryArgs,
}

/// Samples decoded at a time, for a codec that decodes any box.
const PIECE_SAMPLES: usize = 1 << 22;

/// Decodes a container.
///
/// # Errors
/// When arguments, container or output are unusable.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    run_with(args, &Names::new()?)
}

/// As [`run`], with the codecs of a registry.
///
/// # Errors
/// As [`run`].
pub fn run_with(args: &Args, names: &Names) -> Result<ExitCode, BadInput> {
    args.memory.allow();
    check_output(&args.out, &args.container)?;
    let format = Output::of(&args.out, Output::VOLUMES)?;
    let opened = Opened::open(&args.container, names, args.frames.decoded_frames_mb)?;
    let level = args.level.of(opened.codec.as_ref(), &opened.stream.spec().settings)?;
    let mut layout = opened.decoder.layout().at_resolution(level.resolution);
    if args.float {
        layout.sample = SampleType::F32;
    }
    check_size(args, &layout)?;
    // An error of the stream must not be reported as an error of the output file.
    let mut fault = None;
    let written = write_volume_from(&args.out, format, &layout, |out| {
        write_samples(opened.decoder.as_ref(), level, layout.sample, out).map_err(|e| match e {
            Fault::Write(error) => error,
            Fault::Decode(error) => {
                let stopped = std::io::Error::other(error.to_string());
                fault = Some(error);
                stopped
            }
        })
    });
    if let Some(error) = fault {
        return Err(BadInput(format!("{}: {error}", args.container.display())));
    }
    written?;
    say!("{}: {} voxels of {}", args.out.display(), layout.extent, layout.sample);
    if let Some(words) = not_held(format, &layout) {
        say!("{words}");
    }
    Ok(ExitCode::SUCCESS)
}

/// A stream of a few bytes may claim more voxels than any disk can hold.
fn check_size(args: &Args, layout: &VolumeLayout) -> Result<(), BadInput> {
    let (bytes, most) = (layout.bytes(), args.memory.given_bytes().unwrap_or(0).max(MAX_VOLUME_BYTES));
    if bytes <= most {
        return Ok(());
    }
    Err(BadInput(format!(
        "{}: promises {} voxels in {} frame(s), {} of {}; no more than {} are written, the largest volume that cvr reads, \
         unless --max-gb allows as much",
        args.container.display(),
        layout.extent,
        layout.frames,
        gigabytes(bytes),
        layout.sample,
        gigabytes(most)
    )))
}

/// Why voxels were not written.
enum Fault {
    Decode(DecodeError),
    Write(std::io::Error),
}

impl From<DecodeError> for Fault {
    fn from(error: DecodeError) -> Self {
        Self::Decode(error)
    }
}

/// Decodes all frames, and writes them piece by piece.
fn write_samples(
    decoder: &dyn Decoder,
    level: Level,
    sample: SampleType,
    out: &mut dyn Write,
) -> Result<(), Fault> {
    for frame in (0..decoder.layout().frames).map(FrameIndex) {
        decode_pieces(decoder, frame, level, PIECE_SAMPLES, |values| {
            out.write_all(to_samples(sample, values).as_bytes()).map_err(Fault::Write)
        })?;
    }
    Ok(())
}

/// Values rounded and clamped to a number type.
fn to_samples(sample: SampleType, values: &[f32]) -> Samples {
    // A cast from float to integer saturates, which is the intended clamp.
    match sample {
        SampleType::U8 => Samples::U8(values.iter().map(|v| v.round() as u8).collect()),
        SampleType::I8 => Samples::I8(values.iter().map(|v| v.round() as i8).collect()),
        SampleType::U16 => Samples::U16(values.iter().map(|v| v.round() as u16).collect()),
        SampleType::I16 => Samples::I16(values.iter().map(|v| v.round() as i16).collect()),
        _ => Samples::F32(values.to_vec()),
    }
}
