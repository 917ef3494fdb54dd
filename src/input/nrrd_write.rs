//! Writing NRRD: attached header, raw encoding.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

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

    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let io = |source| InputError::Io { place: place.clone(), action: "write the file", source };
    let mut out = temporary_in(folder).map_err(io)?;
    out.write_all(header.as_bytes()).map_err(io)?;
    out.write_all(volume.samples().as_bytes()).map_err(io)?;
    out.as_file().sync_all().map_err(io)?;
    out.persist(path).map_err(|e| io(e.error))?;
    Ok(())
}

/// A temporary file is private by default; the finished one shall have the rights of any new file.
fn temporary_in(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}
