//! Meanings of words in a configuration, if their own type does not document them.

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
