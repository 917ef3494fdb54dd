//! NRRD, "nearly raw raster data": <https://teem.sourceforge.net/nrrd/format.html>.
//!
//! Read are scalar volumes of dimension 3, raw or gzip, attached or detached in one data file.

use std::path::{Path, PathBuf};

use cvr_core::volume::{DenseVolume, SampleType};

use super::header::{Field, Fields, HeaderText, is_file_pattern, shown};
use super::layout::scalar_layout;
use super::payload::{Encoding, Payload, Skip};
use super::{ByteOrder, InputError, Place};

const TYPES: &str = "uint8, int8, uint16, int16, float (and their synonyms)";

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

/// Reads the volume that this header describes.
pub(super) fn read(text: &HeaderText) -> Result<DenseVolume, InputError> {
    let (fields, data_offset) = parse(text)?;
    let dimension = fields.require("dimension", "dimension: 3")?;
    if dimension.number::<u32>("a whole number")? != 3 {
        return Err(dimension.unsupported("dimension 3, a scalar volume; save one volume of a series"));
    }
    if let Some(kinds) = fields.get("kinds") {
        check_kinds(kinds)?;
    }
    let sample = sample_type(fields.require("type", "type: uint8")?)?;
    let sizes = fields.require("sizes", "sizes: 256 256 128")?;
    let layout = scalar_layout(&sizes.place, sizes.dims()?, spacing(&fields)?, sample)?;
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
        byte_order: byte_order(&fields, sample)?,
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
    payload.read(layout)
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

fn check_kinds(kinds: &Field) -> Result<(), InputError> {
    let spatial = ["domain", "space", "none", "???"];
    let is_spatial = |kind: &str| spatial.contains(&kind.to_ascii_lowercase().as_str());
    if kinds.value.split_whitespace().all(is_spatial) {
        Ok(())
    } else {
        Err(kinds.unsupported("the kinds domain and space on all three axes, a scalar volume"))
    }
}

fn sample_type(field: &Field) -> Result<SampleType, InputError> {
    let words: Vec<_> = field.value.split_whitespace().map(str::to_ascii_lowercase).collect();
    match words.join(" ").as_str() {
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Ok(SampleType::U8),
        "char" | "signed char" | "int8" | "int8_t" => Ok(SampleType::I8),
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Ok(SampleType::U16),
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            Ok(SampleType::I16)
        }
        "float" => Ok(SampleType::F32),
        _ => Err(field.unsupported(TYPES)),
    }
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

fn byte_order(fields: &Fields, sample: SampleType) -> Result<ByteOrder, InputError> {
    let Some(field) = fields.get("endian") else {
        // A byte has no order; for anything longer the specification requires the field.
        return if sample.bytes() == 1 {
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

/// From `spacings`, or the lengths of the `space directions`, or 1.
fn spacing(fields: &Fields) -> Result<[f64; 3], InputError> {
    match (fields.get("spacings"), fields.get("spacedirections")) {
        (Some(spacings), Some(directions)) => {
            let (first, second) =
                if spacings.line < directions.line { (spacings, directions) } else { (directions, spacings) };
            Err(second.conflicts(first))
        }
        (Some(spacings), None) => spacings.spacing(),
        (None, Some(directions)) => direction_lengths(directions),
        (None, None) => Ok([1.0; 3]),
    }
}

/// Lengths of three vectors `(a,b,c)`, each of three components, separated by white space.
fn direction_lengths(field: &Field) -> Result<[f64; 3], InputError> {
    let malformed = || field.malformed("three vectors of positive, finite length like `(0.5,0,0)`");
    let mut lengths = [0.0; 3];
    let mut rest = field.value.as_str();
    for length in &mut lengths {
        if rest.to_ascii_lowercase().starts_with("none") {
            return Err(field.unsupported("three spatial axes, each with a vector"));
        }
        let (vector, after) = rest.strip_prefix('(').and_then(|r| r.split_once(')')).ok_or_else(malformed)?;
        let components: Result<Vec<f64>, _> = vector.split(',').map(|c| c.trim().parse()).collect();
        let components: [f64; 3] = components.ok().and_then(|c| c.try_into().ok()).ok_or_else(malformed)?;
        *length = components.iter().map(|c| c * c).sum::<f64>().sqrt();
        if !length.is_finite() || *length <= 0.0 {
            return Err(malformed());
        }
        rest = after.trim_start();
    }
    if rest.is_empty() { Ok(lengths) } else { Err(malformed()) }
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
