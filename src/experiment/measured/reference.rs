//! What all is compared with: the uncompressed volume, and under which sites and filters it is drawn.

use cvr_core::codec::Site;
use cvr_core::render::Filter;
use cvr_core::volume::ValueRange;

/// Id of the codec that holds the uncompressed volume.
pub const RAW: &str = "raw";

/// Renderers subtract values of a volume from each other, in single precision.
///
/// # Errors
/// A sentence, when such a difference overflows: a picture would silently lack what lies there.
pub fn check_range(range: ValueRange) -> Result<(), String> {
    if range.span() <= f64::from(f32::MAX) {
        return Ok(());
    }
    let ValueRange { min, max } = range;
    Err(format!(
        "values from {min:e} to {max:e} cannot be filtered: their differences exceed single precision; scale the volume"
    ))
}

/// The reference of every picture of a frame: the uncompressed volume, filtered in the shader.
pub const REFERENCE: (Site, Filter) = (Site::Inline, Filter::Linear);

/// The baseline of every frame time: the uncompressed texture, filtered by the hardware.
pub const BASELINE: (Site, Filter) = (Site::Host, Filter::Linear);

/// The filter of raw's picture for a cell. *optimised-linear* gives the values of *linear*, and raw does not offer it.
#[must_use]
pub const fn filter_of_raw(filter: Filter) -> Filter {
    match filter {
        Filter::Nearest => Filter::Nearest,
        Filter::Linear | Filter::OptimisedLinear => Filter::Linear,
    }
}
