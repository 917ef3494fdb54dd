//! Rendering, described and not done: a renderer turns a view into a plan, and mirrors itself on the CPU.

mod camera;
mod image;
mod plan;
mod transfer_function;
mod view;
mod voxels;

pub use camera::{Camera, Projection, RayFrame};
pub use image::{Image, ImageError, write_png};
pub use plan::{ComputePass, Pass, Plan, Template};
pub use transfer_function::{ControlPoint, TransferFunction, TransferFunctionError};
pub use view::{Filter, View};
pub use voxels::{Cell, DecodedFrame, DecoderVoxels, Voxels};

use std::fmt::Debug;

use crate::volume::VolumeLayout;

/// Why a renderer cannot draw a view.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// This renderer does not offer what the view asks for.
    #[error("{0}")]
    Unsupported(String),
    /// The mirror could not read a voxel.
    #[error("reading voxels failed: {0}")]
    Voxels(String),
}

/// Walks a volume and makes a picture of it. Pure: describes passes, touches no device.
pub trait Renderer: Send + Sync + Debug {
    /// Name in TOML and records.
    fn id(&self) -> &'static str;

    /// One line for lists.
    fn summary(&self) -> &'static str;

    /// The passes that draw `view` of a volume of this shape.
    ///
    /// # Errors
    /// When the renderer does not offer what the view asks for.
    fn plan(&self, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError>;

    /// The CPU mirror: the same picture by the same arithmetic in Rust. It defines the golden image. On a
    /// [`Filter`] it acts as the manual filters of the shaders do.
    ///
    /// # Errors
    /// As [`Renderer::plan`], and when `voxels` fails.
    ///
    /// # Panics
    /// When `image` has another size than the view.
    fn reference(&self, view: &View, voxels: &dyn Voxels, image: &mut Image) -> Result<(), RenderError>;
}
