//! The abstractions of `cvr`: volumes, codecs, containers, shader generation, render plans, metrics.
//!
//! The way of the data: input → encode → container → plan → shader → image → metrics → report. This crate knows
//! naga (to check shaders) and never wgpu (to run them).

pub mod codec;
#[cfg(feature = "conformance")]
pub mod conformance;
pub mod container;
pub mod diagnostic;
pub mod file;
pub mod kit;
pub mod memory;
pub mod metrics;
pub mod pipeline;
pub mod render;
pub mod shader;
pub mod stability;
pub mod volume;
