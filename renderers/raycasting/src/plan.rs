//! The pass that draws a view.

use cvr_core::render::{ComputePass, Pass, Plan, Rays, RenderError, SceneModules, View};
use cvr_core::volume::VolumeLayout;
use cvr_shaders as shaders;

/// Threads per workgroup along x and y, as `raycasting.wgsl` declares them.
const WORKGROUP: u32 = 8;

pub fn plan(view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
    let SceneModules { mut templates, inputs } = SceneModules::new(view, layout)?;
    let skipping =
        if view.skippable(layout).is_some() { shaders::NEXT_SAMPLE } else { shaders::EVERY_SAMPLE };
    let rays = Rays::AtOnce { module: shaders::RAYS_AT_ONCE, in_pieces: shaders::RAYS_IN_PIECES };
    templates.extend([shaders::RAYCASTING, shaders::RAYS_AT_ONCE, skipping, shaders::OPACITY]);
    let workgroups = [view.size[0].div_ceil(WORKGROUP), view.size[1].div_ceil(WORKGROUP), 1];
    let pass = ComputePass { templates, entry: "raycast", inputs, workgroups, rays };
    Ok(Plan { size: view.size, passes: vec![Pass::Compute(pass)] })
}

#[cfg(test)]
mod tests {
    use cvr_core::render::{ControlPoint, TransferFunction};
    use cvr_core::shader::BindingKind;
    use cvr_core::volume::{Extent, SampleType};

    use super::*;

    #[test]
    fn rays_in_pieces_are_the_same_pass_but_for_one_module() {
        let point = |value| ControlPoint { value, rgba: [1.0; 4] };
        let view = View::new(TransferFunction::new(vec![point(0.0), point(1.0)]).unwrap());
        let layout = VolumeLayout::scalar(Extent::cube(9).unwrap(), SampleType::U8);
        let plan = plan(&view, &layout).unwrap();
        let [Pass::Compute(whole)] = &plan.passes[..] else { panic!("a compute pass") };
        let pieces = whole.in_pieces().unwrap();
        let changed: Vec<_> = whole.templates.iter().zip(&pieces.templates).filter(|(a, b)| a != b).collect();
        assert_eq!(changed, [(&shaders::RAYS_AT_ONCE, &shaders::RAYS_IN_PIECES)]);
        assert_eq!(whole.templates.len(), pieces.templates.len());
        assert_eq!(
            (&whole.inputs, whole.entry, whole.workgroups),
            (&pieces.inputs, pieces.entry, pieces.workgroups)
        );
        assert_eq!(pieces.bindings()[whole.bindings().len()..], [BindingKind::Progress, BindingKind::Pieces]);
        assert_eq!(pieces.in_pieces(), None, "a piece has no pieces");
    }
}
