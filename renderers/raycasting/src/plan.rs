//! The pass that draws a view.

use cvr_core::render::{Plan, RayWalk, RenderError, SceneModules, Stage, View};
use cvr_core::volume::VolumeLayout;

use crate::modules::RAYCASTING;

pub fn plan(view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
    let pass = SceneModules::new(view, layout)?.pass(Stage::Rays(RayWalk::default()), &[RAYCASTING]);
    Ok(Plan { size: view.size, passes: vec![pass] })
}
