//! Headerless files: everything but the voxels is given by the caller.

use std::path::Path;

use cvr_core::volume::{DenseVolume, Extent, SampleType};

use super::layout::scalar_layout;
use super::payload::{Encoding, Payload, Skip};
use super::{ByteOrder, InputError, Place};

/// What a headerless file does not say about itself.
#[derive(Clone, Debug, PartialEq)]
pub struct RawSpec {
    /// Voxels along x (fastest), y, z.
    pub extent: Extent,
    /// Number type of the samples.
    pub sample: SampleType,
    /// Order of the bytes of one sample; without effect on 8-bit types.
    pub byte_order: ByteOrder,
    /// Distance between voxel centres along x, y, z; positive and finite.
    pub spacing: [f64; 3],
    /// Bytes in front of the first voxel.
    pub skip_bytes: u64,
}

impl RawSpec {
    /// Little-endian samples with unit spacing, from the first byte of the file on.
    #[must_use]
    pub const fn new(extent: Extent, sample: SampleType) -> Self {
        Self { extent, sample, byte_order: ByteOrder::Little, spacing: [1.0; 3], skip_bytes: 0 }
    }
}

/// Reads a headerless file, whose voxels must fill it from `skip_bytes` to its end exactly.
///
/// # Errors
/// When the file cannot be read or has another length, the spacing is not positive and finite, or the volume
/// is larger than [`super::MAX_VOLUME_BYTES`].
pub fn open_raw(path: &Path, spec: &RawSpec) -> Result<DenseVolume, InputError> {
    let place = Place::file(path);
    let layout = scalar_layout(&place, spec.extent.to_array(), spec.spacing, spec.sample)?;
    let payload = Payload {
        file: path.to_owned(),
        place,
        offset: 0,
        skip_lines: 0,
        skip: Skip::Bytes(spec.skip_bytes),
        stored_bytes: None,
        encoding: Encoding::Raw,
        byte_order: spec.byte_order,
    };
    payload.read(layout)
}
