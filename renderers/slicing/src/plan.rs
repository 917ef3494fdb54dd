//! The pass that draws a view.

use cvr_core::render::{
    Input, Pass, Plan, RasterPass, RenderError, SceneModules, Template, View, uniform_bytes,
};
use cvr_core::shader::BindingKind;
use cvr_core::volume::VolumeLayout;
use cvr_shaders as shaders;

use crate::proxies::proxies;
use crate::slabs::Slabs;
use crate::{Geometry, OpacityCorrection, Slicing};

pub fn plan(slicing: &Slicing, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
    let (_, pass) = slices(slicing, view, layout, shaders::SLICES_AT_ONCE)?;
    Ok(Plan { size: view.size, passes: vec![Pass::Raster(pass)] })
}

/// All slices, with the corners that `proxy` says, and the slabs that they stand for.
pub fn slices(
    slicing: &Slicing,
    view: &View,
    layout: &VolumeLayout,
    proxy: Template,
) -> Result<(Slabs, RasterPass), RenderError> {
    let SceneModules { mut templates, mut inputs } = SceneModules::new(view, layout)?;
    let rays = view.rays(layout);
    let slabs = Slabs::new(slicing.geometry, view, layout, &rays)?;
    inputs.push(Input { kind: BindingKind::Slabs, contents: uniform_bytes(&slabs.uniform())? });
    if view.skippable(layout).is_none() {
        templates.push(shaders::EVERY_POINT);
    }
    templates.extend([
        shaders::SLICING,
        shaders::SLICES_UNCHECKED,
        proxy,
        match slabs.geometry {
            Geometry::Planes | Geometry::Axis => shaders::SLABS_FLAT,
            Geometry::Shells => shaders::SLABS_SHELLS,
        },
        match slicing.opacity_correction {
            OpacityCorrection::Exact => shaders::SLICE_OPACITY_EXACT,
            OpacityCorrection::Lerp => shaders::SLICE_OPACITY_LERP,
        },
        shaders::OPACITY,
    ]);
    let pass = RasterPass {
        templates,
        vertex: "proxy",
        fragment: "slice",
        inputs,
        vertices: proxies(&slabs, view, layout, &rays),
        blending: slicing.blending,
        checked: Some((shaders::SLICES_UNCHECKED, &[shaders::SLICES_CHECKED, shaders::LOOPS_RUN])),
    };
    Ok((slabs, pass))
}
