//! Writing NRRD: attached header, raw encoding.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use cvr_core::file::write_whole;
use cvr_core::volume::{BrickSource as _, DenseVolume, SampleType};

use super::{ByteOrder, InputError, Place};

/// Writes one scalar frame as an NRRD file that [`super::open`] reads back bit for bit.
///
/// The file appears under its name only when it is whole; one that stood there before is replaced then.
///
/// # Errors
/// When the volume has several channels or frames, or the folder is missing or cannot be written to.
pub fn write_nrrd(path: &Path, volume: &DenseVolume) -> Result<(), InputError> {
    let layout = volume.layout();
    let place = Place::file(path);
    let type_name = match layout.sample {
        SampleType::U8 => "uint8",
        SampleType::I8 => "int8",
        SampleType::U16 => "uint16",
        SampleType::I16 => "int16",
        SampleType::F32 => "float",
        other => {
            return Err(InputError::Unsupported {
                place,
                found: format!("sample type {other}"),
                supported: "u8, i8, u16, i16, f32".to_owned(),
            });
        }
    };
    if (layout.channels, layout.frames) != (1, 1) {
        let (extent, channels, frames) = (layout.extent, layout.channels, layout.frames);
        return Err(InputError::Unwritable { place, extent, channels, frames });
    }
    let [nx, ny, nz] = layout.extent.to_array();
    let [dx, dy, dz] = layout.spacing;
    let mut header = format!(
        "NRRD0004\ntype: {type_name}\ndimension: 3\nsizes: {nx} {ny} {nz}\nspacings: {dx} {dy} {dz}\n"
    );
    if layout.sample.bytes() > 1 {
        let _ = writeln!(header, "endian: {}", ByteOrder::NATIVE.name());
    }
    header.push_str("encoding: raw\n\n");

    write_whole(path, |out| {
        out.write_all(header.as_bytes())?;
        out.write_all(volume.samples().as_bytes())
    })
    .map_err(|source| InputError::Io { place, action: "write the file", source })
}
