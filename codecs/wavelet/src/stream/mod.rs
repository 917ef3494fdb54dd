//! What a stream consists of.

pub mod pyramid;
