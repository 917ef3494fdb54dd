//! What a run would take, before it runs: time and memory, estimated.
//!
//! Volumes are opened for their headers alone ([`volume_layout`]). What a codec makes of a volume is measured on a small
//! computed one of the same number type ([`Trial`]): seconds per voxel, bytes per voxel, and what frames take on the
//! target that would draw, within an [`Allowance`]. [`memory`] and [`time`] scale that up; each says what it counts and what
//! it leaves out, and what no trial could tell.

mod allowance;
pub mod memory;
pub mod time;
mod trial;
mod trials;
mod volume;

pub use allowance::Allowance;
pub use trial::{Frames, TRIAL_EDGE, Trial};
pub use trials::{Cost, Trials};
pub use volume::volume_layout;
