//! Front-to-back raycasting as one compute pass, with its mirror on the CPU.
//!
//! The pass (`shaders/raycasting/raycasting.wgsl`) and the mirror ([`mirror`]) are the same arithmetic in the
//! same order, both in single precision; the mirror defines the golden image.

mod mirror;
mod plan;

use cvr_core::render::{Image, Plan, RenderError, Renderer, View, Voxels};
use cvr_core::volume::VolumeLayout;

/// The renderer `raycasting`.
#[derive(Copy, Clone, Debug, Default)]
pub struct Raycasting;

impl Renderer for Raycasting {
    fn id(&self) -> &'static str {
        "raycasting"
    }

    fn summary(&self) -> &'static str {
        "rays front to back, early termination; one compute pass"
    }

    fn plan(&self, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
        scalar_only(layout)?;
        plan::plan(view, layout)
    }

    fn reference(&self, view: &View, voxels: &dyn Voxels, image: &mut Image) -> Result<(), RenderError> {
        scalar_only(voxels.layout())?;
        mirror::draw(view, voxels, image)
    }
}

fn scalar_only(layout: &VolumeLayout) -> Result<(), RenderError> {
    if layout.channels == 1 {
        return Ok(());
    }
    Err(RenderError::Unsupported(format!(
        "raycasting classifies scalar volumes; this one has {} channels",
        layout.channels
    )))
}
