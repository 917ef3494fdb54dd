//! Estimates of a run's time and memory, before it runs.
//!
//! Only the headers of volumes are read ([`volume_layout`]). A trial encodes and draws a small computed volume of the
//! same number type ([`Trial`]). It measures seconds per voxel, bytes per voxel, and frame times on the target, within
//! an [`Allowance`]. [`memory`] and [`time`] scale the results up. Each states what it counts, what it leaves out, and
//! what no trial could measure.

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
