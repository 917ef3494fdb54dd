//! NIfTI-1 in one file (`.nii`, `.nii.gz`): <https://nifti.nimh.nih.gov/nifti-1>.
//!
//! The crate `nifti` reads the header. The voxels are read here, because its reader reserves all the memory that the header
//! claims before it looks at the file.

use std::io::BufReader;

use cvr_core::volume::StoredType;
use flate2::bufread::MultiGzDecoder;
use nifti::{Endianness, NiftiHeader};

use super::axes::Axis;
use super::header::HeaderText;
use super::layout::{Shape, StoredLayout};
use super::payload::{Described, Encoding, Payload, Skip, open_regular};
use super::samples::{Scale, fill};
use super::{ByteOrder, InputError, Place};

/// Bytes of the header.
const HEADER_BYTES: usize = 348;
/// Header and the four bytes that say whether extensions follow: where voxels begin if the header does not say.
const DEFAULT_OFFSET: u64 = 352;

/// Whether these are the first bytes of a NIfTI file, version 2 and detached headers included: those are refused by
/// name.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    let one = bytes.get(344..348).is_some_and(|m| m == b"n+1\0" || m == b"ni1\0");
    one || is_version_2(bytes)
}

fn is_version_2(bytes: &[u8]) -> bool {
    bytes.get(4..8).is_some_and(|m| m == b"n+2\0" || m == b"ni2\0")
}

/// The first bytes of a gzip stream, decompressed; as many as there are.
pub(super) fn unpacked_start(text: &HeaderText) -> Result<Vec<u8>, InputError> {
    let place = Place::file(text.path());
    let (file, _) = open_regular(text.path(), &place)?;
    let mut bytes = vec![0; HEADER_BYTES];
    let (filled, _) = fill(&mut MultiGzDecoder::new(BufReader::new(file)), &mut bytes);
    bytes.truncate(filled);
    Ok(bytes)
}

/// Reads the header of a volume whose (decompressed) file begins with `start`.
pub(super) fn read(text: &HeaderText, start: &[u8], encoding: Encoding) -> Result<Described, InputError> {
    let path = text.path();
    let place = |field: &str| Place::part(path, format!("field `{field}`"));
    let unsupported = |field: &str, found: String, supported: &str| InputError::Unsupported {
        place: place(field),
        found,
        supported: supported.to_owned(),
    };
    if is_version_2(start) {
        let one = "NIfTI-1; save it as that";
        return Err(unsupported("sizeof_hdr", "NIfTI-2".to_owned(), one));
    }
    let malformed = |field: &str, problem: String, remedy: &str| InputError::Header {
        place: place(field),
        problem,
        remedy: remedy.to_owned(),
    };
    let Some(bytes) = start.get(..HEADER_BYTES) else {
        return Err(InputError::Header {
            place: Place::file(path),
            problem: format!("a NIfTI header takes {HEADER_BYTES} bytes, but only {} are there", start.len()),
            remedy: "the file is cut short: fetch it again".to_owned(),
        });
    };
    let header = NiftiHeader::from_reader(bytes).map_err(|e| InputError::Header {
        place: Place::part(path, "header"),
        problem: format!("this is no header of NIfTI-1 ({e})"),
        remedy: "save the volume again as NIfTI-1, .nii or .nii.gz".to_owned(),
    })?;
    if header.sizeof_hdr != 348 {
        let problem = format!("`sizeof_hdr` is {}, or `dim[0]` is not 1 to 7", header.sizeof_hdr);
        return Err(malformed("sizeof_hdr", problem, "wanted: 348, in the byte order of `dim`"));
    }
    match &header.magic {
        b"n+1\0" => {}
        b"ni1\0" => {
            let found = "a header without its voxels (.hdr, .img)".to_owned();
            return Err(unsupported("magic", found, "header and voxels in one file, .nii or .nii.gz"));
        }
        _ => return Err(malformed("magic", "`magic` is not `n+1`".to_owned(), "wanted: a NIfTI-1 file")),
    }
    let (stored, colour) = sample_type(header.datatype)
        .ok_or_else(|| unsupported("datatype", format!("`datatype` {}", header.datatype), TYPES))?;
    let size_problem = |problem| malformed("dim", problem, "wanted: 3 to 5 axes of 1 to 32767 voxels");
    let (shape, axes) = shape(&header, colour).map_err(size_problem)?;
    let spacing = spacing(&header).map_err(|problem| {
        malformed("pixdim", problem, "wanted: positive, finite lengths for the axes in space")
    })?;
    let layout = StoredLayout::new(&place("dim"), shape, spacing, stored)?;
    let offset = voxel_offset(header.vox_offset).ok_or_else(|| {
        let problem = format!("`vox_offset` is {}", header.vox_offset);
        malformed("vox_offset", problem, "wanted: a whole number of bytes, 348 or more, usually 352")
    })?;
    let scale = if colour { None } else { scale(&header) };
    if scale.is_some_and(|s| !s.intercept.is_finite()) {
        let problem = format!("`scl_inter` is {}", header.scl_inter);
        return Err(malformed("scl_inter", problem, "wanted: a finite number, 0 for none"));
    }
    let layout = if scale.is_some() { layout.scaled(&place("dim"))? } else { layout };
    let payload = Payload {
        file: path.to_owned(),
        place: Place::file(path),
        offset: 0,
        skip_lines: 0,
        skip: Skip::Bytes(offset),
        stored_bytes: None,
        encoding,
        byte_order: if header.endianness == Endianness::Big { ByteOrder::Big } else { ByteOrder::Little },
        scale,
    };
    Ok(Described { layout, payload, axes })
}

const TYPES: &str = "u8 (2), i8 (256), u16 (512), i16 (4), u32 (768), i32 (8), u64 (1280), i64 (1024), f32 (16), \
                     f64 (64), RGB24 (128)";

/// Number type, and whether a voxel has three of them.
const fn sample_type(code: i16) -> Option<(StoredType, bool)> {
    Some(match code {
        2 => (StoredType::U8, false),
        4 => (StoredType::I16, false),
        8 => (StoredType::I32, false),
        16 => (StoredType::F32, false),
        64 => (StoredType::F64, false),
        128 => (StoredType::U8, true),
        256 => (StoredType::I8, false),
        512 => (StoredType::U16, false),
        768 => (StoredType::U32, false),
        1024 => (StoredType::I64, false),
        1280 => (StoredType::U64, false),
        _ => return None,
    })
}

/// Axes 1 to 3 are those in space, 4 is time, 5 holds the components of vectors, one volume after another.
fn shape(header: &NiftiHeader, colour: bool) -> Result<(Shape, Vec<Axis>), String> {
    let n = usize::from(header.dim[0]);
    if !(1..=7).contains(&n) {
        return Err(format!("`dim[0]` is {n}"));
    }
    let mut sizes = [1_u32; 7];
    for (size, dim) in sizes.iter_mut().zip(&header.dim[1..=n]) {
        // The crate reads the signed number as an unsigned one.
        *size = if (1..=32767).contains(dim) { u32::from(*dim) } else { 0 };
    }
    let [x, y, z, frames, components, sixth, seventh] = sizes;
    let channels = if colour { 3 } else { components };
    let possible = !sizes.contains(&0)
        && (sixth, seventh) == (1, 1)
        && matches!(channels, 1 | 3)
        && (!colour || components == 1);
    if !possible {
        let dims: Vec<i16> = header.dim[1..=n].iter().map(|d| d.cast_signed()).collect();
        return Err(format!("`dim` is {dims:?}, which is no volume of 1 or 3 channels"));
    }
    let axes = if colour {
        vec![Axis::Channel, Axis::X, Axis::Y, Axis::Z, Axis::Frame]
    } else {
        vec![Axis::X, Axis::Y, Axis::Z, Axis::Frame, Axis::Channel]
    };
    Ok((Shape { dims: [x, y, z], channels, frames }, axes))
}

/// `pixdim[1..=3]`, which says nothing of axes that the file has not.
fn spacing(header: &NiftiHeader) -> Result<[f64; 3], String> {
    let mut spacing = [1.0; 3];
    for (axis, to) in spacing.iter_mut().enumerate().take(usize::from(header.dim[0])) {
        *to = f64::from(header.pixdim[axis + 1]);
        if !to.is_finite() || *to <= 0.0 {
            return Err(format!("`pixdim[{}]` is {to}", axis + 1));
        }
    }
    Ok(spacing)
}

/// Scaling is off where the slope is 0, or no finite number, as `nibabel` has it.
fn scale(header: &NiftiHeader) -> Option<Scale> {
    let (slope, intercept) = (f64::from(header.scl_slope), f64::from(header.scl_inter));
    let is_on = slope != 0.0 && slope.is_finite() && (slope, intercept) != (1.0, 0.0);
    is_on.then_some(Scale { slope, intercept })
}

fn voxel_offset(offset: f32) -> Option<u64> {
    if offset == 0.0 {
        return Some(DEFAULT_OFFSET);
    }
    let whole = offset.fract() == 0.0 && offset >= HEADER_BYTES as f32 && offset < (1_u64 << 40) as f32;
    whole.then_some(offset as u64)
}
