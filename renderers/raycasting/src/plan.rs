//! The pass that draws a view.

use cvr_core::render::{ComputePass, Pass, Plan, RenderError, SceneModules, View};
use cvr_core::volume::VolumeLayout;
use cvr_shaders as shaders;

/// Threads per workgroup along x and y, as `raycasting.wgsl` declares them.
const WORKGROUP: u32 = 8;

pub fn plan(view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
    let SceneModules { mut templates, inputs } = SceneModules::new(view, layout)?;
    let skipping =
        if view.skippable(layout).is_some() { shaders::NEXT_SAMPLE } else { shaders::EVERY_SAMPLE };
    templates.extend([shaders::RAYCASTING, skipping, shaders::OPACITY]);
    let workgroups = [view.size[0].div_ceil(WORKGROUP), view.size[1].div_ceil(WORKGROUP), 1];
    let pass = ComputePass { templates, entry: "raycast", inputs, workgroups };
    Ok(Plan { size: view.size, passes: vec![Pass::Compute(pass)] })
}
