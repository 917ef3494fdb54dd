//! What the words of a configuration mean, where the thing itself does not say it.

use crate::render::Filter;

/// A filter.
pub(super) const fn filter(filter: Filter) -> &'static str {
    match filter {
        Filter::Nearest => "the voxel that a point lies in",
        Filter::Linear => "trilinear between eight voxels",
        Filter::OptimisedLinear => {
            "trilinear, the eight voxels out of one call: at the site inline, of codecs that offer it"
        }
    }
}
