//! The pass that draws a view.

use cvr_core::render::{Pass, Plan, Proxies, RenderError, SceneModules, Stage, Template, View};
use cvr_core::volume::VolumeLayout;

use crate::modules::{OPACITY_EXACT, OPACITY_LERP, SLABS_FLAT, SLABS_SHELLS, SLICES_AT_ONCE, SLICING};
use crate::proxies::proxies;
use crate::slabs::Slabs;
use crate::{Geometry, OpacityCorrection, Slicing};

pub fn plan(slicing: &Slicing, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
    let (_, pass) = slices(slicing, view, layout, SLICES_AT_ONCE, |_, proxies| Stage::Triangles(proxies))?;
    Ok(Plan { size: view.size, passes: vec![pass] })
}

/// All slices, with the vertices that `proxy` declares, and their slabs.
pub fn slices(
    slicing: &Slicing,
    view: &View,
    layout: &VolumeLayout,
    proxy: Template,
    stage: impl FnOnce(&Slabs, Proxies) -> Stage,
) -> Result<(Slabs, Pass), RenderError> {
    let rays = view.rays(layout);
    let slabs = Slabs::new(slicing.geometry, view, layout, &rays)?;
    let mut scene = SceneModules::new(view, layout)?;
    scene.uniform("slabs", "Slabs", &slabs.uniform())?;
    let geometry = match slabs.geometry {
        Geometry::Planes | Geometry::Axis => SLABS_FLAT,
        Geometry::Shells => SLABS_SHELLS,
    };
    let opacity = match slicing.opacity_correction {
        OpacityCorrection::Exact => OPACITY_EXACT,
        OpacityCorrection::Lerp => OPACITY_LERP,
    };
    let stage = stage(&slabs, Proxies { vertex: "proxy", blending: slicing.blending });
    let mut pass = scene.pass(stage, &[SLICING, proxy, geometry, opacity]);
    pass.inputs.vertices = proxies(&slabs, view, layout, &rays);
    Ok((slabs, pass))
}
