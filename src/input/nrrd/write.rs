//! Writing NRRD: attached header, raw encoding.

use std::fmt::Write as _;
use std::path::Path;

use cvr_core::file::write_whole;
use cvr_core::volume::{BrickSource as _, DenseVolume, SampleType};

use super::super::{ByteOrder, InputError, Place};

/// Writes an NRRD file that [`crate::input::open`] reads back bit for bit: scalars as three axes, colours with an
/// axis `RGB-color` before them, several frames with an axis `list` behind them.
///
/// The file appears under its name only when it is whole; one that stood there before is replaced then.
///
/// # Errors
/// When the folder is missing or cannot be written to.
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
    let space = |i: usize| (layout.extent.to_array()[i].to_string(), layout.spacing[i].to_string(), "domain");
    let mut axes = vec![space(0), space(1), space(2)];
    let none = || "nan".to_owned();
    if layout.channels != 1 {
        axes.insert(0, (layout.channels.to_string(), none(), "RGB-color"));
    }
    if layout.frames != 1 {
        axes.push((layout.frames.to_string(), none(), "list"));
    }
    let line = |of: &dyn Fn(&(String, String, &'static str)) -> String| {
        axes.iter().map(of).collect::<Vec<_>>().join(" ")
    };
    let mut header = format!(
        "NRRD0004\ntype: {type_name}\ndimension: {}\nsizes: {}\nspacings: {}\n",
        axes.len(),
        line(&|a| a.0.clone()),
        line(&|a| a.1.clone())
    );
    if axes.len() > 3 {
        let _ = writeln!(header, "kinds: {}", line(&|a| a.2.to_owned()));
    }
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
