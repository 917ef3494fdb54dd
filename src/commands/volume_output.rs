//! Volumes written in the format that was asked for, with what the format has no place for.

use std::io::Write as _;
use std::path::Path;

use cvr_core::file::write_whole;
use cvr_core::volume::{BrickSource as _, DenseVolume};

use super::output::Output;
use crate::exit::BadInput;
use crate::input::{ByteOrder, write_npy, write_nrrd};

/// Writes a volume, with its channels and frames.
///
/// # Errors
/// When the file cannot be written.
pub fn write_volume(path: &Path, format: Output, volume: &DenseVolume) -> Result<(), BadInput> {
    match format {
        Output::Npy => Ok(write_npy(path, volume)?),
        Output::Raw => write_whole(path, |out| out.write_all(volume.samples().as_bytes()))
            .map_err(|e: std::io::Error| BadInput(format!("{}: cannot write the file: {e}", path.display()))),
        _ => Ok(write_nrrd(path, volume)?),
    }
}

/// What must be said to read the file again, for the format does not hold it.
pub fn not_held(format: Output, volume: &DenseVolume) -> Option<String> {
    let layout = volume.layout();
    match format {
        Output::Raw => Some(format!("read it with{}", raw_arguments(volume))),
        Output::Npy if layout.spacing != [1.0; 3] => {
            let [x, y, z] = layout.spacing;
            Some(format!("NPY has no place for the spacing: read it with --spacing {x},{y},{z}"))
        }
        _ => None,
    }
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
