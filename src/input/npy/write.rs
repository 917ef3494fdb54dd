//! Writing NPY: C order, this machine's byte order.

use std::path::Path;

use cvr_core::file::write_whole;
use cvr_core::volume::{BrickSource as _, DenseVolume, SampleType};
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
    let layout = volume.layout();
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
    let header = Header { type_descriptor, layout: Layout::Standard, shape: shape(volume) };
    let header = header.to_bytes().map_err(|e| invalid(&e))?;
    write_whole(path, |out| {
        out.write_all(&header)?;
        out.write_all(volume.samples().as_bytes())
    })
    .map_err(|source| InputError::Io { place, action: "write the file", source })
}

/// The shortest shape that is read as it was meant: a last axis of 3 means colours, even if it is that of x.
fn shape(volume: &DenseVolume) -> Vec<usize> {
    let layout = volume.layout();
    let [x, y, z] = layout.extent.to_array().map(|n| n as usize);
    let (channels, frames) = (layout.channels as usize, layout.frames as usize);
    match (frames, channels) {
        (1, 1) => vec![z, y, x],
        (1, _) => vec![z, y, x, channels],
        (_, 1) if x != 3 => vec![frames, z, y, x],
        _ => vec![frames, z, y, x, channels],
    }
}
