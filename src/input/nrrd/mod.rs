//! NRRD, "nearly raw raster data": <https://teem.sourceforge.net/nrrd/format.html>.
//!
//! Read are volumes of three axes in space, besides at most one of 3 values and one of frames; raw or gzip, attached
//! or detached in one data file.

mod axes;
mod write;

pub use write::{write_nrrd, write_nrrd_from};

use std::path::{Path, PathBuf};

use cvr_core::volume::StoredType;

use super::header::{Field, Fields, HeaderText, is_file_pattern, shown};
use super::layout::StoredLayout;
use super::payload::{Described, Encoding, Payload, Skip};
use super::{ByteOrder, InputError, Place};

const TYPES: &str =
    "uint8, int8, uint16, int16, uint32, int32, uint64, int64, float, double (and their synonyms)";

/// Fields of the specification that say nothing about how voxels are stored or spaced, or that are ignored
/// for now. Any other unread field is refused: a misspelt `spacings` must not become a spacing of 1.
const IGNORED: [&str; 20] = [
    "axismaxs",
    "axismins",
    "blocksize",
    "centerings",
    "centers",
    "content",
    "labels",
    "max",
    "measurementframe",
    "min",
    "number",
    "oldmax",
    "oldmin",
    "sampleunits",
    "space",
    "spacedimension",
    "spaceorigin",
    "spaceunits",
    "thicknesses",
    "units",
];

const READ: [&str; 11] = [
    "byteskip",
    "datafile",
    "dimension",
    "encoding",
    "endian",
    "kinds",
    "lineskip",
    "sizes",
    "spacedirections",
    "spacings",
    "type",
];

/// Whether the file begins like an NRRD file of any version.
pub(super) fn has_magic(text: &HeaderText) -> bool {
    text.starts_with(b"NRRD")
}

/// Reads the header of a volume.
pub(super) fn read(text: &HeaderText) -> Result<Described, InputError> {
    let (fields, data_offset) = parse(text)?;
    let dimension = axes::dimension(&fields)?;
    let stored = sample_type(fields.require("type", "type: uint8")?)?;
    let read = axes::read(&fields, dimension)?;
    let layout = StoredLayout::new(&axes::place(&fields), read.shape, read.spacing, stored)?;
    let encoding = encoding(fields.require("encoding", "encoding: raw")?)?;
    let skip_lines = match fields.get("lineskip") {
        Some(field) => field.number("a whole number of lines, 0 or more")?,
        None => 0,
    };
    let mut payload = Payload {
        file: text.path().to_owned(),
        place: Place::file(text.path()),
        offset: 0,
        skip_lines,
        skip: byte_skip(&fields, encoding)?,
        stored_bytes: None,
        encoding,
        byte_order: byte_order(&fields, stored)?,
        scale: None,
    };
    match (fields.get("datafile"), data_offset) {
        (Some(field), _) => {
            payload.file = data_file(field, text.path())?;
            payload.place =
                Place::Data { data: payload.file.clone(), header: text.path().to_owned(), line: field.line };
        }
        (None, Some(offset)) => payload.offset = offset,
        (None, None) => {
            return Err(InputError::Header {
                place: payload.place,
                problem: "the header names no data file, and no empty line ends it".to_owned(),
                remedy: "add `data file: NAME`, or an empty line between header and data".to_owned(),
            });
        }
    }
    Ok(Described { layout, payload, axes: read.axes })
}

/// The fields, and the offset behind the empty line that ends the header (`None`: no such line).
fn parse(text: &HeaderText) -> Result<(Fields, Option<u64>), InputError> {
    let mut fields = Fields::of(text);
    let mut lines = text.lines();
    match lines.next() {
        Some(line) if matches!(version(&line.text), Some(1..=5)) => {}
        line => {
            return Err(InputError::Unsupported {
                place: text.place(1),
                found: format!("the magic {}", shown(&line.map(|l| l.text).unwrap_or_default())),
                supported: "NRRD0001 to NRRD0005".to_owned(),
            });
        }
    }
    for line in lines {
        if line.text.is_empty() {
            return Ok((fields, Some(line.end)));
        }
        if line.text.starts_with('#') {
            continue;
        }
        let Some((name, value)) = line.text.split_once(':') else {
            return Err(text.malformed(&line, "wanted: `field: value`, `key:=value`, or a `# comment`"));
        };
        if value.starts_with('=') {
            continue;
        }
        let normalised = name.to_ascii_lowercase().replace(char::is_whitespace, "");
        if IGNORED.contains(&normalised.as_str()) {
            continue;
        }
        if !READ.contains(&normalised.as_str()) {
            return Err(InputError::Header {
                place: text.place(line.number),
                problem: format!("NRRD has no field {}", shown(name)),
                remedy: "correct its name; keys of your own are written `key:=value`".to_owned(),
            });
        }
        fields.add(normalised, Field::on(text, &line, name, value))?;
    }
    Ok((fields, None))
}

fn version(magic: &str) -> Option<u32> {
    magic.strip_prefix("NRRD000").and_then(|v| v.parse().ok())
}

fn sample_type(field: &Field) -> Result<StoredType, InputError> {
    let words: Vec<_> = field.value.split_whitespace().map(str::to_ascii_lowercase).collect();
    Ok(match words.join(" ").as_str() {
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => StoredType::U8,
        "char" | "signed char" | "int8" | "int8_t" => StoredType::I8,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => StoredType::U16,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => StoredType::I16,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => StoredType::U32,
        "int" | "signed int" | "int32" | "int32_t" => StoredType::I32,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => {
            StoredType::U64
        }
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => StoredType::I64,
        "float" => StoredType::F32,
        "double" => StoredType::F64,
        _ => return Err(field.unsupported(TYPES)),
    })
}

fn encoding(field: &Field) -> Result<Encoding, InputError> {
    match field.value.to_ascii_lowercase().as_str() {
        "raw" => Ok(Encoding::Raw),
        "gzip" | "gz" => Ok(Encoding::Gzip),
        _ => Err(field.unsupported("raw, gzip")),
    }
}

/// In gzip data the skip counts decompressed bytes, as the specification has it.
fn byte_skip(fields: &Fields, encoding: Encoding) -> Result<Skip, InputError> {
    let Some(field) = fields.get("byteskip") else {
        return Ok(Skip::Bytes(0));
    };
    let wanted = match encoding {
        Encoding::Raw => "a whole number of bytes, or -1 for data at the end of the file",
        _ => "a whole number of bytes (-1 goes with `encoding: raw` only)",
    };
    match field.number::<i64>(wanted)? {
        -1 if encoding == Encoding::Raw => Ok(Skip::AllButVoxels),
        n => u64::try_from(n).map(Skip::Bytes).map_err(|_| field.malformed(wanted)),
    }
}

fn byte_order(fields: &Fields, stored: StoredType) -> Result<ByteOrder, InputError> {
    let Some(field) = fields.get("endian") else {
        // A byte has no order; for anything longer the specification requires the field.
        return if stored.bytes() == 1 {
            Ok(ByteOrder::Little)
        } else {
            Err(fields.missing("endian: little"))
        };
    };
    match field.value.to_ascii_lowercase().as_str() {
        "little" => Ok(ByteOrder::Little),
        "big" => Ok(ByteOrder::Big),
        _ => Err(field.malformed("`little` or `big`")),
    }
}

/// The one data file, relative to the folder of the header.
fn data_file(field: &Field, header: &Path) -> Result<PathBuf, InputError> {
    let name = field.value.as_str();
    if name.is_empty() {
        return Err(field.malformed("the name of a file, relative to the header"));
    }
    if name.split_whitespace().next() == Some("LIST") || is_file_pattern(name) {
        return Err(field.unsupported("one data file; join the files of the series into one"));
    }
    Ok(header.with_file_name(name))
}
