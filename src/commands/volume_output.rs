//! Writes volumes in the requested format, with a note about data that the format cannot hold.

use std::io::Write;
use std::path::Path;

use cvr_core::file::write_whole;
use cvr_core::volume::{BrickSource as _, DenseVolume, VolumeLayout};

use super::output::Output;
use crate::exit::BadInput;
use crate::input::{ByteOrder, write_npy_from, write_nrrd_from};

/// Writes a volume, with its channels and frames.
///
/// # Errors
/// When the file cannot be written.
pub fn write_volume(path: &Path, format: Output, volume: &DenseVolume) -> Result<(), BadInput> {
    write_volume_from(path, format, volume.layout(), |out| out.write_all(volume.samples().as_bytes()))
}

/// As [`write_volume`], for samples that need not be in memory at once. `samples` writes them in this machine's byte
/// order: x fastest, channels interleaved, frame after frame.
///
/// # Errors
/// As [`write_volume`]; also when `samples` fails, and no file is there then.
pub fn write_volume_from(
    path: &Path,
    format: Output,
    layout: &VolumeLayout,
    samples: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), BadInput> {
    match format {
        Output::Npy => Ok(write_npy_from(path, layout, samples)?),
        Output::Raw => write_whole(path, |out| samples(out))
            .map_err(|e: std::io::Error| BadInput(format!("{}: cannot write the file: {e}", path.display()))),
        _ => Ok(write_nrrd_from(path, layout, samples)?),
    }
}

/// The arguments that are needed to read the file again, because the format does not hold their values.
pub fn not_held(format: Output, layout: &VolumeLayout) -> Option<String> {
    match format {
        Output::Raw => Some(format!("read it with{}", raw_arguments(layout))),
        Output::Npy if layout.spacing != [1.0; 3] => {
            let [x, y, z] = layout.spacing;
            Some(format!("NPY has no place for the spacing: read it with --spacing {x},{y},{z}"))
        }
        _ => None,
    }
}

/// The arguments that describe a headerless file of this volume.
fn raw_arguments(layout: &VolumeLayout) -> String {
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
