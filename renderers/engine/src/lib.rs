//! The only crate that names wgpu: devices, resources, execution, read-back, timing.
//!
//! A [`Device`] is opened once and shared. A [`Drawing`] is a runnable [`cvr_core::render::Plan`]: shader generated,
//! pipeline built, voxels resident. A device keeps its pipelines, so an equal request compiles nothing. Every driver
//! error is returned as an [`EngineError`] of the call that caused it. Nothing here panics or aborts because of a
//! device.

mod adapter;
mod bindings;
mod block_texture;
mod canvas;
mod capabilities;
mod compile;
mod cpu_time;
mod decoding;
mod device;
mod drawing;
mod dump;
mod error;
mod frame_passes;
mod guard;
mod layers;
mod open;
mod pipelines;
mod probes;
mod raster;
mod readback;
mod reports;
mod slabs;
mod source;
mod texels;
mod texture;
mod timestamps;
#[cfg(test)]
mod toy;
mod upload;

pub mod testing;
pub mod timing;

pub use adapter::{Backend, DeviceChoice, DeviceInfo, DeviceKind, list_adapters};
pub use capabilities::{BlockFallback, Capabilities, TextureChoice, TextureFallback};
pub use cpu_time::process_cpu_time;
pub use decoding::FrameDecoder;
pub use device::Device;
pub use drawing::{Drawing, RayPieces};
pub use error::EngineError;
pub use source::{DrawSource, VolumeBuffers};
pub use texture::VolumeTexture;
