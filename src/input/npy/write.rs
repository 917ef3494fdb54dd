//! Writing NPY: C order, this machine's byte order.

use std::io::Write;
use std::path::Path;

use cvr_core::file::write_whole;
use cvr_core::volume::{BrickSource as _, DenseVolume, SampleType, VolumeLayout};
use ndarray_npy::npy::header::{Header, Layout};

use super::super::{ByteOrder, InputError, Place};

/// Writes an NPY file that [`crate::input::open`] reads back bit for bit, but for the spacing, which the format has
/// no place for.
///
/// The file appears under its name only when it is whole; one that stood there before is replaced then.
///
/// # Errors
/// When the folder is missing or cannot be written to.
pub fn write_npy(path: &Path, volume: &DenseVolume) -> Result<(), InputError> {
    write_npy_from(path, volume.layout(), |out| out.write_all(volume.samples().as_bytes()))
}

/// The same of samples that need not be in memory at once: `samples` writes those of the layout, in this machine's byte
/// order, x fastest, channels interleaved, frame after frame.
///
/// # Errors
/// As [`write_npy`]; also when `samples` fails, and no file is there then.
pub fn write_npy_from(
    path: &Path,
    layout: &VolumeLayout,
    samples: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), InputError> {
    let place = Place::file(path);
    let order = match (layout.sample.bytes(), ByteOrder::NATIVE) {
        (1, _) => '|',
        (_, ByteOrder::Little) => '<',
        (_, ByteOrder::Big) => '>',
    };
    let name = match layout.sample {
        SampleType::U8 => "u1",
        SampleType::I8 => "i1",
        SampleType::U16 => "u2",
        SampleType::I16 => "i2",
        SampleType::F32 => "f4",
        other => {
            let (found, supported) = (format!("sample type {other}"), "u8, i8, u16, i16, f32".to_owned());
            return Err(InputError::Unsupported { place, found, supported });
        }
    };
    let invalid = |e: &dyn std::fmt::Display| InputError::Io {
        place: place.clone(),
        action: "write the header",
        source: std::io::Error::other(e.to_string()),
    };
    let type_descriptor = format!("'{order}{name}'").parse().map_err(|e| invalid(&e))?;
    let header = Header { type_descriptor, layout: Layout::Standard, shape: shape(layout) };
    let header = header.to_bytes().map_err(|e| invalid(&e))?;
    write_whole(path, |out| {
        out.write_all(&header)?;
        samples(out)
    })
    .map_err(|source| InputError::Io { place, action: "write the file", source })
}

/// The shortest shape that is read as it was meant: a last axis of 4 or less may be channels, even if it is that of x.
fn shape(layout: &VolumeLayout) -> Vec<usize> {
    let [x, y, z] = layout.extent.to_array().map(|n| n as usize);
    let (channels, frames) = (layout.channels as usize, layout.frames as usize);
    match (frames, channels) {
        (1, 1) => vec![z, y, x],
        (1, _) => vec![z, y, x, channels],
        (_, 1) if x > 4 => vec![frames, z, y, x],
        _ => vec![frames, z, y, x, channels],
    }
}
