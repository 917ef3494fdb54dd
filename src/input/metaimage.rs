//! MetaImage, the image format of ITK's MetaIO: <https://itk.org/Wiki/ITK/MetaIO/Documentation>.
//!
//! Reads volumes of three axes, or four (the last holds frames), with 1 or 3 channels, raw or zlib, in the same file
//! (`LOCAL`) or in one data file.

use std::path::PathBuf;

use cvr_core::volume::StoredType;

use super::header::{Field, Fields, HeaderText, is_file_pattern};
use super::layout::{Shape, StoredLayout};
use super::payload::{Described, Encoding, Payload, Skip};
use super::{ByteOrder, InputError, Place};

/// MetaImage has no magic; these keys begin the files that MetaIO and others write.
pub(super) fn looks_like(text: &HeaderText) -> bool {
    let first = text.lines().find(|l| !l.text.is_empty());
    let key = first.as_ref().and_then(|l| l.text.split_once('=')).map(|(key, _)| key.trim());
    matches!(key, Some("ObjectType" | "NDims" | "Comment"))
}

/// Reads the header of a volume.
pub(super) fn read(text: &HeaderText) -> Result<Described, InputError> {
    let (fields, data_offset) = parse(text)?;
    if let Some(object) = fields.get("objecttype")
        && !object.value.eq_ignore_ascii_case("Image")
    {
        return Err(object.unsupported("Image"));
    }
    let axes = fields.require("ndims", "NDims = 3")?;
    let axes = match axes.number::<u32>("a whole number")? {
        n @ (3 | 4) => n as usize,
        _ => return Err(axes.unsupported("NDims = 3, or 4 for frames")),
    };
    let channels = match fields.get("elementnumberofchannels") {
        None => 1,
        Some(field) => match field.number::<u32>("a whole number")? {
            n @ (1 | 3) => n,
            _ => return Err(field.unsupported("1 (scalar) or 3 (RGB)")),
        },
    };
    if let Some(binary) = fields.get("binarydata")
        && !truth(binary)?
    {
        return Err(binary.unsupported("BinaryData = True"));
    }
    let stored = sample_type(fields.require("elementtype", "ElementType = MET_UCHAR")?)?;
    let spacing = match fields.get("elementspacing").or_else(|| fields.get("elementsize")) {
        Some(field) if axes == 4 => {
            let wanted = "four positive, finite numbers: the spacing along x, y and z, and of time steps";
            let [x, y, z, t]: [f64; 4] = field.numbers(wanted)?;
            if ![x, y, z, t].iter().all(|s| s.is_finite() && *s > 0.0) {
                return Err(field.malformed(wanted));
            }
            [x, y, z]
        }
        Some(field) => field.spacing()?,
        None => [1.0; 3],
    };
    let size = fields.require("dimsize", "DimSize = 256 256 128")?;
    let sizes = size.sizes(axes)?;
    let frames = sizes.get(3).copied().unwrap_or(1);
    let shape = Shape { dims: [sizes[0], sizes[1], sizes[2]], channels, frames };
    let layout = StoredLayout::new(&size.place, shape, spacing, stored)?;
    let (file, place, data_offset) = data_file(&fields, text, data_offset)?;
    let encoding = match fields.get("compresseddata") {
        Some(field) if truth(field)? => Encoding::Zlib,
        _ => Encoding::Raw,
    };
    let (offset, skip) = header_size(&fields, encoding, data_offset)?;
    // Without compression the key means nothing.
    let stored_bytes = match fields.get("compresseddatasize") {
        Some(field) if encoding == Encoding::Zlib => Some(field.number("a whole number of bytes")?),
        _ => None,
    };
    let byte_order = byte_order(&fields)?;
    let payload =
        Payload { file, place, offset, skip_lines: 0, skip, stored_bytes, encoding, byte_order, scale: None };
    Ok(Described { layout, payload, axes: Vec::new() })
}

/// The fields up to `ElementDataFile`, which ends the header, and the offset behind that line.
fn parse(text: &HeaderText) -> Result<(Fields, u64), InputError> {
    let mut fields = Fields::of(text);
    for line in text.lines().filter(|l| !l.text.is_empty()) {
        let Some((name, value)) = line.text.split_once('=') else {
            return Err(text.malformed(&line, "wanted: `Key = Value`, up to `ElementDataFile = …`"));
        };
        let normalised = name.trim().to_ascii_lowercase();
        let is_last = normalised == "elementdatafile";
        // Keys of one's own are legal, and may repeat; of those that are read, none may.
        if READ.contains(&normalised.as_str()) {
            fields.add(normalised, Field::on(text, &line, name, value))?;
        }
        if is_last {
            return Ok((fields, line.end));
        }
    }
    Err(fields.missing("ElementDataFile = LOCAL"))
}

const READ: [&str; 14] = [
    "binarydata",
    "binarydatabyteordermsb",
    "compresseddata",
    "compresseddatasize",
    "dimsize",
    "elementbyteordermsb",
    "elementdatafile",
    "elementnumberofchannels",
    "elementsize",
    "elementspacing",
    "elementtype",
    "headersize",
    "ndims",
    "objecttype",
];

fn truth(field: &Field) -> Result<bool, InputError> {
    match field.value.to_ascii_lowercase().as_str() {
        "true" | "1" => Ok(true),
        "false" | "0" => Ok(false),
        _ => Err(field.malformed("`True` or `False`")),
    }
}

/// `MET_LONG` has 32 bits, as in MetaIO's table of sizes, independent of the machine's `long`.
fn sample_type(field: &Field) -> Result<StoredType, InputError> {
    Ok(match field.value.as_str() {
        "MET_UCHAR" => StoredType::U8,
        "MET_CHAR" => StoredType::I8,
        "MET_USHORT" => StoredType::U16,
        "MET_SHORT" => StoredType::I16,
        "MET_UINT" | "MET_ULONG" => StoredType::U32,
        "MET_INT" | "MET_LONG" => StoredType::I32,
        "MET_ULONG_LONG" => StoredType::U64,
        "MET_LONG_LONG" => StoredType::I64,
        "MET_FLOAT" => StoredType::F32,
        "MET_DOUBLE" => StoredType::F64,
        _ => {
            return Err(field.unsupported(
                "MET_UCHAR, MET_CHAR, MET_USHORT, MET_SHORT, MET_UINT, MET_INT, MET_ULONG, MET_LONG, \
                 MET_ULONG_LONG, MET_LONG_LONG, MET_FLOAT, MET_DOUBLE",
            ));
        }
    })
}

/// Two keys mean the same; little-endian where both are absent.
fn byte_order(fields: &Fields) -> Result<ByteOrder, InputError> {
    let keys = (fields.get("binarydatabyteordermsb"), fields.get("elementbyteordermsb"));
    let most_significant_first = match keys {
        (Some(a), Some(b)) if truth(a)? != truth(b)? => {
            let (first, second) = if a.line < b.line { (a, b) } else { (b, a) };
            return Err(second.conflicts(first));
        }
        (Some(field), _) | (None, Some(field)) => truth(field)?,
        (None, None) => false,
    };
    Ok(if most_significant_first { ByteOrder::Big } else { ByteOrder::Little })
}

/// File of the voxels, what errors call it, and where in it the data begin.
fn data_file(
    fields: &Fields,
    text: &HeaderText,
    data_offset: u64,
) -> Result<(PathBuf, Place, u64), InputError> {
    let field = fields.require("elementdatafile", "ElementDataFile = LOCAL")?;
    let name = field.value.as_str();
    match name {
        "" => Err(field.malformed("`LOCAL`, or the name of a file, relative to the header")),
        "LOCAL" | "Local" | "local" => Ok((text.path().to_owned(), Place::file(text.path()), data_offset)),
        _ if name.split_whitespace().next() == Some("LIST") || is_file_pattern(name) => {
            Err(field
                .unsupported("LOCAL or one data file, not one file per slice; save the volume as a whole"))
        }
        _ => {
            let data = text.path().with_file_name(name);
            let header = text.path().to_owned();
            Ok((data.clone(), Place::Data { data, header, line: field.line }, 0))
        }
    }
}

/// `HeaderSize` counts from the beginning of the data's file; -1 puts the data at its end.
fn header_size(fields: &Fields, encoding: Encoding, data_offset: u64) -> Result<(u64, Skip), InputError> {
    let Some(field) = fields.get("headersize") else {
        return Ok((data_offset, Skip::Bytes(0)));
    };
    let wanted = match encoding {
        Encoding::Raw => "a whole number of bytes, or -1 for data at the end of the file",
        _ => "a whole number of bytes (-1 goes with uncompressed data only)",
    };
    match field.number::<i64>(wanted)? {
        -1 if encoding == Encoding::Raw => Ok((data_offset, Skip::AllButVoxels)),
        0 => Ok((data_offset, Skip::Bytes(0))),
        n => u64::try_from(n).map(|n| (n, Skip::Bytes(0))).map_err(|_| field.malformed(wanted)),
    }
}
