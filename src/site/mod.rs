//! Sites: one file for each way of holding a volume.
//!
//! A [`Site`] names how much of a volume is decoded at once, and who decodes it. One [`Holding`] per site implements
//! it: preparation of a frame, the input of shader generator and device, comparison with the CPU decoder, remarks, and
//! estimates. Commands call [`of`] and never test for a site by name.
//!
//! * [`holding`]: the questions
//! * [`inline`], [`deferred`], [`ring`], [`host`]: the answers
//! * [`coded`], [`expected`]: a frame of a stream, the CPU's decoded frame, and the result of a comparison
//! * [`target`], [`picture`]: the device or mirror, and its pictures
//! * [`kept`]: frames that several pictures share

pub mod coded;
pub mod deferred;
pub mod expected;
pub mod holding;
pub mod host;
pub mod host_texture;
pub mod inline;
pub mod kept;
pub mod picture;
pub mod ring;
pub mod target;

use cvr_core::codec::Site;

use holding::Holding;

/// The implementation of a site.
#[must_use]
pub const fn of(site: Site) -> &'static dyn Holding {
    match site {
        Site::Inline => &inline::Inline,
        Site::Deferred => &deferred::Deferred,
        Site::Ring => &ring::Ring,
        Site::Host => &host::Host,
    }
}
