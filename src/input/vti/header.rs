//! Content of the elements of a VTI file.

use cvr_core::volume::StoredType;

use super::super::{ByteOrder, Place};

/// Content and encoding of a file.
#[derive(Debug)]
pub(super) struct Header {
    pub byte_order: ByteOrder,
    /// Bytes of each number in front of binary data: 4 or 8.
    pub word_bytes: usize,
    /// Whether binary data come in zlib blocks.
    pub is_compressed: bool,
    /// Points along x, y, z; at least 1 each.
    pub points: [u32; 3],
    pub spacing: [f64; 3],
    pub active_of_points: Option<String>,
    pub active_of_cells: Option<String>,
    pub arrays: Vec<Array>,
    pub appended: Option<Appended>,
    /// Where each appended array begins, in bytes after the start of the appended data.
    pub appended_offsets: Vec<u64>,
}

/// The appended data.
#[derive(Copy, Clone, Debug)]
pub(super) struct Appended {
    /// Offset in the file of the first byte behind the underscore.
    pub offset: u64,
    pub is_base64: bool,
}

/// To what the values belong.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Association {
    Points,
    Cells,
}

impl Association {
    pub const fn element(self) -> &'static str {
        match self {
            Self::Points => "PointData",
            Self::Cells => "CellData",
        }
    }
}

/// One `<DataArray>` of the piece.
#[derive(Debug)]
pub(super) struct Array {
    pub place: Place,
    pub association: Association,
    pub name: String,
    pub stored: StoredType,
    pub components: u32,
    pub format: Format,
}

/// Where an array's values stand.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// As text, from this offset in the file.
    Ascii(u64),
    /// As base64, from this offset in the file.
    Binary(u64),
    /// So many bytes behind the appended data's beginning.
    Appended(u64),
}

/// The number type of a `type` attribute.
pub(super) fn sample_type(name: &str) -> Option<StoredType> {
    Some(match name {
        "UInt8" => StoredType::U8,
        "Int8" => StoredType::I8,
        "UInt16" => StoredType::U16,
        "Int16" => StoredType::I16,
        "UInt32" => StoredType::U32,
        "Int32" => StoredType::I32,
        "UInt64" => StoredType::U64,
        "Int64" => StoredType::I64,
        "Float32" => StoredType::F32,
        "Float64" => StoredType::F64,
        _ => return None,
    })
}
