//! From claimed dimensions to a layout, with the guard on the total size.

use cvr_core::volume::{Extent, SampleType, VolumeLayout};

use super::{InputError, MAX_VOLUME_BYTES, Place};

/// The layout of one scalar frame. `place` is where the dimensions are claimed.
///
/// # Errors
/// When a dimension is zero, a spacing is not a positive finite length, or the volume is too large.
pub(super) fn scalar_layout(
    place: &Place,
    dims: [u32; 3],
    spacing: [f64; 3],
    sample: SampleType,
) -> Result<VolumeLayout, InputError> {
    let header = |problem: String, remedy: &str| InputError::Header {
        place: place.clone(),
        problem,
        remedy: remedy.to_owned(),
    };
    // Three 32-bit factors and a sample size cannot overflow 128 bits.
    let bytes = dims.iter().map(|&n| u128::from(n)).product::<u128>() * sample.bytes() as u128;
    if bytes > u128::from(MAX_VOLUME_BYTES) {
        return Err(InputError::TooLarge { place: place.clone(), dims, bytes });
    }
    let extent =
        Extent::try_from(dims).map_err(|e| header(e.to_string(), "correct the dimensions of the volume"))?;
    let layout = VolumeLayout { spacing, ..VolumeLayout::scalar(extent, sample) };
    layout.validate().map_err(|e| header(e.to_string(), "correct the spacing, or leave it out for 1"))?;
    Ok(layout)
}
