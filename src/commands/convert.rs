//! `cvr convert`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use cvr_core::file::write_whole;
use cvr_core::volume::{BrickSource, DenseVolume};

use super::volume_args::{RawArgs, check_output, is_container};
use crate::exit::BadInput;
use crate::input::{ByteOrder, write_npy, write_nrrd};

const EXAMPLES: &str = "\
Examples:
  cvr convert head.nii.gz head.nrrd
  cvr convert slices/ head.npy
  cvr convert flow.raw flow.nrrd --dims 128x128x41 --dtype f32";

/// Arguments of `cvr convert`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The volume: a file of any format, a folder of slices, or a pattern like 'step*.raw' whose files are frames; of
    /// several, the frames follow each other. The last of the paths is the file to write.
    #[arg(required = true, num_args = 1.., value_name = "IN")]
    files: Vec<PathBuf>,
    /// The file to write: `.nrrd`, `.npy`, or `.raw` for samples without a header.
    out: PathBuf,
    #[command(flatten)]
    raw: RawArgs,
}

/// The formats that are written.
#[derive(Copy, Clone)]
enum Format {
    Nrrd,
    Npy,
    Raw,
}

impl Format {
    fn of(path: &Path) -> Result<Self, BadInput> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        match extension.as_str() {
            "nrrd" => Ok(Self::Nrrd),
            "npy" => Ok(Self::Npy),
            "raw" => Ok(Self::Raw),
            _ => Err(BadInput(format!(
                "{}: the extension names the format to write: .nrrd, .npy or .raw",
                path.display()
            ))),
        }
    }
}

/// Writes a volume in another format, with its channels and frames.
///
/// # Errors
/// When arguments, volume or output are unusable.
pub fn run(args: &Args) -> Result<ExitCode, BadInput> {
    let format = Format::of(&args.out)?;
    for file in &args.raw.found(&args.files)? {
        check_output(&args.out, file)?;
        if is_container(file) {
            return Err(BadInput(format!("{} is encoded: use `cvr decode`", file.display())));
        }
    }
    let input = args.raw.read_all(&args.files)?;
    let layout = input.volume.layout();
    match format {
        Format::Nrrd => write_nrrd(&args.out, &input.volume)?,
        Format::Npy => write_npy(&args.out, &input.volume)?,
        Format::Raw => write_raw(&args.out, &input.volume)?,
    }
    say!(
        "{}: {} of {}, {} per voxel, {} frame(s)",
        args.out.display(),
        layout.extent,
        layout.sample,
        layout.channels,
        layout.frames
    );
    if let Format::Raw = format {
        say!("read it with{}", raw_arguments(&input.volume));
    }
    if let (Format::Npy, [x, y, z]) = (format, layout.spacing)
        && layout.spacing != [1.0; 3]
    {
        say!("NPY has no place for the spacing: read it with --spacing {x},{y},{z}");
    }
    if input.rounded > 0 {
        say!("{} samples of {} were rounded to single precision", input.rounded, input.stored);
    }
    Ok(ExitCode::SUCCESS)
}

fn write_raw(path: &Path, volume: &DenseVolume) -> Result<(), BadInput> {
    write_whole(path, |out| out.write_all(volume.samples().as_bytes()))
        .map_err(|e| BadInput(format!("{}: cannot write the file: {e}", path.display())))
}

/// The arguments that describe a headerless file of this volume.
fn raw_arguments(volume: &DenseVolume) -> String {
    let layout = volume.layout();
    let [x, y, z] = layout.extent.to_array();
    let mut text = format!(" --dims {x}x{y}x{z} --dtype {}", layout.sample);
    if layout.sample.bytes() > 1 && ByteOrder::NATIVE == ByteOrder::Big {
        text.push_str(" --byte-order big");
    }
    for (name, n) in [("channels", layout.channels), ("frames", layout.frames)] {
        if n != 1 {
            text.push_str(&format!(" --{name} {n}"));
        }
    }
    if layout.spacing != [1.0; 3] {
        let [x, y, z] = layout.spacing;
        text.push_str(&format!(" --spacing {x},{y},{z}"));
    }
    text
}
