//! Rendering as a description: a renderer turns a view into a plan, and has a CPU mirror.

mod camera;
mod clip;
mod coarse;
mod colour;
mod error;
mod image;
mod layers;
mod macrocells;
pub mod mirror;
mod modules;
mod plan;
mod preset;
mod renderer;
mod shading;
mod transfer_function;
mod uniforms;
mod upsampled;
mod view;
mod voxels;

pub use camera::{Camera, Projection, RayFrame};
pub use clip::ClipBox;
pub use coarse::Coarse;
pub use colour::{ColourOpacity, OpacityTable, OpacityTableError};
pub use error::RenderError;
pub use image::{Image, ImageError, to_png, write_png};
pub use layers::{LayerStep, RING_LAYERS};
pub use macrocells::{MacrocellRanges, Macrocells};
pub use modules::SceneModules;
pub use plan::{
    Blending, Contents, Inputs, Pass, Pipeline, Plan, Proxies, ProxyVertex, RayWalk, Stage, Template,
};
pub use preset::Preset;
pub use renderer::{Renderer, RendererInfo};
pub use shading::{Light, Shading};
pub use transfer_function::{ControlPoint, SegmentSearch, TransferFunction, TransferFunctionError};
pub use uniforms::uniform_bytes;
pub use upsampled::upsampled;
pub use view::{Filter, View};
pub use voxels::{Cell, DecoderVoxels, Voxels};

pub use crate::codec::DecodedFrame;
