//! Memory for voxels and streams: the limit, the use, and the refusal of buffers that are too large.
//!
//! A system grants more memory than it has and ends the process that uses it. A failed allocation is therefore no limit.
//! If a file, a configuration or a user names the size of a buffer, code asks before it reserves the buffer ([`check`],
//! [`zeroed`]). The owner of such a buffer counts it for as long as it lives ([`Held`]). The limit is one of the process
//! ([`allow`]); without a limit nothing is refused. Pictures, the memory of a device driver, and small buffers are not
//! counted.

mod account;
mod free;

pub use account::{Bound, Held, OutOfMemory, Source, allow, allowed, check, gigabytes, zeroed};
pub use free::free;
