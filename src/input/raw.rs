//! Headerless files: everything but the voxels is given by the caller.

use std::path::Path;

use cvr_core::pipeline::RawLayout;

use super::layout::{Shape, StoredLayout};
use super::payload::{Described, Encoding, Payload, Skip};
use super::{InputError, Place};

/// A headerless file, whose voxels must fill it from `skip_bytes` to its end exactly.
pub(super) fn read(path: &Path, raw: &RawLayout) -> Result<Described, InputError> {
    let place = Place::file(path);
    let shape = Shape { dims: raw.extent.to_array(), channels: raw.channels, frames: raw.frames };
    let layout = StoredLayout::new(&place, shape, raw.spacing, raw.stored)?;
    let payload = Payload {
        file: path.to_owned(),
        place,
        offset: 0,
        skip_lines: 0,
        skip: Skip::Bytes(raw.skip_bytes),
        stored_bytes: None,
        encoding: Encoding::Raw,
        byte_order: raw.byte_order,
        scale: None,
    };
    Ok(Described { layout, payload, axes: Vec::new() })
}
