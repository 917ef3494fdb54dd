//! Memory for voxels and streams: how much may be taken, how much is taken, and the refusal of what is too much.
//!
//! A system grants more memory than it has and ends the process that uses it, so that a failed allocation is not a bound.
//! Whoever is about to reserve a buffer whose size a file, a configuration or a user names, asks first ([`check`],
//! [`zeroed`]); whatever keeps such a buffer says so for as long as it lives ([`Held`]). The bound is that of the process
//! ([`allow`]); without one nothing is refused. Not counted are pictures, what a device driver takes, and the small
//! change of a process.

mod account;
mod free;

pub use account::{Bound, Held, OutOfMemory, Source, allow, allowed, check, gigabytes, zeroed};
pub use free::free;
