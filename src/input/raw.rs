//! Headerless files: everything but the voxels is given by the caller.

use std::path::Path;

use cvr_core::pipeline::RawLayout;
use cvr_core::volume::DenseVolume;

use super::layout::scalar_layout;
use super::payload::{Encoding, Payload, Skip};
use super::{InputError, Place};

/// Reads a headerless file, whose voxels must fill it from `skip_bytes` to its end exactly.
///
/// # Errors
/// When the file cannot be read or has another length, the spacing is not positive and finite, or the volume
/// is larger than [`super::MAX_VOLUME_BYTES`].
pub fn open_raw(path: &Path, raw: &RawLayout) -> Result<DenseVolume, InputError> {
    let place = Place::file(path);
    let layout = scalar_layout(&place, raw.extent.to_array(), raw.spacing, raw.sample)?;
    let payload = Payload {
        file: path.to_owned(),
        place,
        offset: 0,
        skip_lines: 0,
        skip: Skip::Bytes(raw.skip_bytes),
        stored_bytes: None,
        encoding: Encoding::Raw,
        byte_order: raw.byte_order,
    };
    payload.read(layout)
}
