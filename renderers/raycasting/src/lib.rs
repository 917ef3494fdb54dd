//! Front-to-back raycasting as one compute pass, with its mirror on the CPU.
//!
//! The pass (`shaders/raycasting/raycasting.wgsl`, under `shaders/rays/`) and the mirror (`mirror.rs`) use the same
//! arithmetic in the same order, in single precision. The mirror defines the golden image.

mod mirror;
pub mod modules;
mod plan;

use std::sync::Arc;

use cvr_core::codec::{ConfigError, Settings};
use cvr_core::render::{Image, Plan, RenderError, Renderer, RendererInfo, View, Voxels};
use cvr_core::volume::VolumeLayout;

const INFO: RendererInfo = RendererInfo {
    id: "raycasting",
    summary: "rays front to back, early termination; one compute pass",
    settings: &[],
    layers: None,
};

/// The renderer `raycasting`.
#[derive(Copy, Clone, Debug, Default)]
pub struct Raycasting;

impl Renderer for Raycasting {
    fn info(&self) -> &'static RendererInfo {
        &INFO
    }

    fn with(&self, _: &Settings) -> Result<Arc<dyn Renderer>, ConfigError> {
        Ok(Arc::new(*self))
    }

    fn plan(&self, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
        plan::plan(view, layout)
    }

    fn reference(&self, view: &View, voxels: &dyn Voxels, image: &mut Image) -> Result<(), RenderError> {
        mirror::draw(view, voxels, image)
    }
}
