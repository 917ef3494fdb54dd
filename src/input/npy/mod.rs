//! NPY, the array file of NumPy: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.
//!
//! The index of an array is `[z, y, x]`, `[frame, z, y, x]`, `[z, y, x, 3]` (colours: a last axis of 3) or
//! `[frame, z, y, x, channel]`, in any memory order. Of four axes a last one of 1, 2 or 4 is
//! refused: it may be channels.
//!
//! The crate `ndarray-npy` reads the header. The voxels are read here, because its arrays reserve all the memory that the
//! header claims before they look at the file.

mod write;

pub use write::{write_npy, write_npy_from};

use cvr_core::volume::StoredType;
use ndarray_npy::npy::header::{Header, Layout};

use super::axes::Axis;
use super::header::{HeaderText, shown};
use super::layout::{Shape, StoredLayout};
use super::payload::{Described, Encoding, Payload, Skip};
use super::{ByteOrder, InputError, Place};

/// Longest header that is parsed, in bytes. NumPy writes some hundred.
const MAX_HEADER_BYTES: usize = 1 << 16;
/// Brackets within brackets that the header's dictionary may have: the parser recurses.
const MAX_DEPTH: usize = 8;

pub(super) fn has_magic(text: &HeaderText) -> bool {
    text.starts_with(b"\x93NUMPY")
}

/// Reads the header of a volume.
pub(super) fn read(text: &HeaderText) -> Result<Described, InputError> {
    let path = text.path();
    let malformed = |problem: String, remedy: &str| InputError::Header {
        place: Place::part(path, "header"),
        problem,
        remedy: remedy.to_owned(),
    };
    let length = header_bytes(text.bytes()).map_err(|problem| malformed(problem, "is this an NPY file?"))?;
    let bytes = &text.bytes()[..length];
    let header = Header::from_reader(&mut &bytes[..])
        .map_err(|e| malformed(shown(&e.to_string()), "save the array again with `numpy.save`"))?;
    let descriptor = header.type_descriptor.to_string();
    let (stored, byte_order) =
        sample_type(descriptor.trim_matches('\'')).ok_or_else(|| InputError::Unsupported {
            place: Place::part(path, "`descr` of the header"),
            found: format!("the type {}", shown(&descriptor)),
            supported: "u1, i1, u2, i2, u4, i4, u8, i8, f4, f8, each < or >".to_owned(),
        })?;
    if let [_, _, _, n @ (1 | 2 | 4)] = header.shape[..] {
        return Err(InputError::Unsupported {
            place: Place::part(path, "`shape` of the header"),
            found: format!(
                "the shape {}, whose last axis may be {n} channels, or x in frames,",
                shown(&format!("{:?}", header.shape))
            ),
            supported: "frames as [frame, z, y, x, 1] (`array[..., None]`), or one channel as [z, y, x] (`array[..., 0]`)"
                .to_owned(),
        });
    }
    let (shape, index) = shape(&header.shape).ok_or_else(|| InputError::Unsupported {
        place: Place::part(path, "`shape` of the header"),
        found: format!("the shape {}", shown(&format!("{:?}", header.shape))),
        supported: "[z, y, x], [frame, z, y, x], [z, y, x, 3], [frame, z, y, x, channel], none of them 0"
            .to_owned(),
    })?;
    let layout = StoredLayout::new(&Place::part(path, "`shape` of the header"), shape, [1.0; 3], stored)?;
    let mut fastest_first = index;
    if header.layout != Layout::Fortran {
        fastest_first.reverse();
    }
    let payload = Payload {
        file: path.to_owned(),
        place: Place::file(path),
        offset: length as u64,
        skip_lines: 0,
        skip: Skip::Bytes(0),
        stored_bytes: None,
        encoding: Encoding::Raw,
        byte_order,
        scale: None,
    };
    Ok(Described { layout, payload, axes: fastest_first })
}

/// Length of magic, version, length and dictionary, which lie within `bytes` and are not too deep for the parser.
fn header_bytes(bytes: &[u8]) -> Result<usize, String> {
    let (start, length) = match bytes {
        [_, _, _, _, _, _, 1, _, a, b, ..] => (10, usize::from(u16::from_le_bytes([*a, *b]))),
        [_, _, _, _, _, _, 2 | 3, _, a, b, c, d, ..] => {
            (12, usize::try_from(u32::from_le_bytes([*a, *b, *c, *d])).unwrap_or(usize::MAX))
        }
        [_, _, _, _, _, _, version, ..] => return Err(format!("version {version} of NPY is unknown")),
        _ => return Err("the file ends within its header".to_owned()),
    };
    if length > MAX_HEADER_BYTES {
        return Err(format!(
            "the header claims {length} bytes, and more than {MAX_HEADER_BYTES} make no sense"
        ));
    }
    let Some(dictionary) = bytes.get(start..start + length) else {
        return Err(format!("the header claims {length} bytes, but only {} are there", bytes.len() - start));
    };
    let mut depth = 0_usize;
    for byte in dictionary {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > MAX_DEPTH {
            return Err("the header's dictionary has too many brackets within brackets".to_owned());
        }
    }
    Ok(start + length)
}

/// A type as `<f4`.
fn sample_type(descriptor: &str) -> Option<(StoredType, ByteOrder)> {
    let (order, name) = descriptor.split_at_checked(1)?;
    let stored = match name {
        "u1" => StoredType::U8,
        "i1" => StoredType::I8,
        "u2" => StoredType::U16,
        "i2" => StoredType::I16,
        "u4" => StoredType::U32,
        "i4" => StoredType::I32,
        "u8" => StoredType::U64,
        "i8" => StoredType::I64,
        "f4" => StoredType::F32,
        "f8" => StoredType::F64,
        _ => return None,
    };
    match order {
        "<" => Some((stored, ByteOrder::Little)),
        ">" => Some((stored, ByteOrder::Big)),
        "|" if stored.bytes() == 1 => Some((stored, ByteOrder::Little)),
        _ => None,
    }
}

/// The meanings of an array's axes.
fn shape(shape: &[usize]) -> Option<(Shape, Vec<Axis>)> {
    let index = match shape {
        [_, _, _] => vec![Axis::Z, Axis::Y, Axis::X],
        [_, _, _, 3] => vec![Axis::Z, Axis::Y, Axis::X, Axis::Channel],
        [_, _, _, _] => vec![Axis::Frame, Axis::Z, Axis::Y, Axis::X],
        [_, _, _, _, 1 | 3] => vec![Axis::Frame, Axis::Z, Axis::Y, Axis::X, Axis::Channel],
        _ => return None,
    };
    let size = |axis| {
        let at = index.iter().position(|a| *a == axis);
        let size = at.map_or(1, |i| u32::try_from(shape[i]).unwrap_or(u32::MAX));
        (size > 0).then_some(size)
    };
    let dims = [size(Axis::X)?, size(Axis::Y)?, size(Axis::Z)?];
    let shape = Shape { dims, channels: size(Axis::Channel)?, frames: size(Axis::Frame)? };
    Some((shape, index))
}
