//! The abstractions of `cvr`: volumes, codecs, containers, shader generation, render plans, metrics.
//!
//! Data flow: input → encode → container → plan → shader → image → metrics → report. This crate uses naga (to check
//! shaders) but never wgpu (to run them).

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
