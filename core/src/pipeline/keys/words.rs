//! What the words of a configuration mean, where the thing itself does not say it.

use crate::codec::Site;
use crate::render::Filter;

/// A decode site.
pub(super) const fn site(site: Site) -> &'static str {
    match site {
        Site::Inline => "in the shader, at every fetch",
        Site::Deferred => "on the device, a whole frame at once, into a texture",
        Site::Ring => {
            "on the device, layer by layer in every frame, into a ring of four: of renderer slicing with geometry axis"
        }
        Site::Host => "on the CPU, into a texture",
    }
}

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
