//! Where voxels come from: one file for each way of holding a volume.
//!
//! A [`Site`] is a name for how much of a volume is decoded at once and for who decodes it. What that means is answered by
//! one [`Holding`]: how a frame is prepared, what the shader generator and a device read, how it is held to the CPU
//! decoder, what is noted, and what it is likely to take. All commands ask the list of [`of`]; none asks for names of sites.
//!
//! * [`holding`]: the questions
//! * [`inline`], [`deferred`], [`ring`], [`host`]: the answers
//! * [`coded`], [`expected`]: a frame of a stream, what the CPU decodes of it, and what comparing with it has found
//! * [`target`], [`picture`]: what draws, and what is drawn
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

/// What a site is.
#[must_use]
pub const fn of(site: Site) -> &'static dyn Holding {
    match site {
        Site::Inline => &inline::Inline,
        Site::Deferred => &deferred::Deferred,
        Site::Ring => &ring::Ring,
        Site::Host => &host::Host,
    }
}
