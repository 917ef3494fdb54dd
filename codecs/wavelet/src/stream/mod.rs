//! What a stream consists of.

pub mod parameters;
pub mod pyramid;

/// Bytes of the container's header, about: it is a multiple of this.
pub const HEADER: f64 = 2048.0;
