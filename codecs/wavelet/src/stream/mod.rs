//! What a stream consists of.

pub mod parameters;
pub mod pyramid;
