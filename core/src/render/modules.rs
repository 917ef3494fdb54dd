//! The modules that a view needs of every renderer's shader, and no more.

use cvr_shaders as shaders;

use super::uniforms::{ClipUniform, LightingUniform, ViewUniform, uniform_bytes};
use super::{Input, Projection, RenderError, Template, View};
use crate::shader::BindingKind;
use crate::volume::VolumeLayout;

/// What a view adds to a renderer's own template: rays, bounds, classification, shading, skipping.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneModules {
    /// Modules.
    pub templates: Vec<Template>,
    /// What they read.
    pub inputs: Vec<Input>,
}

impl SceneModules {
    /// The modules of a view of a volume.
    ///
    /// # Errors
    /// When no module classifies such a volume.
    pub fn new(view: &View, layout: &VolumeLayout) -> Result<Self, RenderError> {
        scalar_only(layout)?;
        let rays = view.camera.rays(layout, view.size);
        let table = bytemuck::cast_slice(view.transfer_function.table()).to_vec();
        let mut templates = vec![shaders::VIEW, shaders::CLASSIFY_SCALAR];
        let mut inputs = vec![
            Input { kind: BindingKind::View, contents: uniform_bytes(&ViewUniform::new(view, &rays))? },
            Input { kind: BindingKind::TransferTable, contents: table },
        ];
        templates.push(match view.camera.projection {
            Projection::Perspective => shaders::CAMERA_PERSPECTIVE,
            Projection::Orthographic => shaders::CAMERA_ORTHOGRAPHIC,
        });
        if view.clip.is_some() {
            templates.push(shaders::BOUNDS_CLIP);
            let contents = uniform_bytes(&ClipUniform::new(view.bounds(layout.extent)))?;
            inputs.push(Input { kind: BindingKind::Clip, contents });
        } else {
            templates.push(shaders::BOUNDS_WHOLE);
        }
        if let Some(shading) = &view.shading {
            templates.extend([shaders::OPTICS_LIT, shaders::GRADIENT, shaders::BLINN_PHONG]);
            let contents = uniform_bytes(&LightingUniform::new(view, shading, &rays))?;
            inputs.push(Input { kind: BindingKind::Lighting, contents });
        } else {
            templates.push(shaders::OPTICS_UNLIT);
        }
        if let Some(macrocells) = &view.macrocells {
            templates.push(shaders::MACROCELLS);
            let contents = bytemuck::cast_slice(macrocells.words()).to_vec();
            inputs.push(Input { kind: BindingKind::Macrocells, contents });
        }
        Ok(Self { templates, inputs })
    }
}

/// Every renderer classifies scalars.
pub(super) fn scalar_only(layout: &VolumeLayout) -> Result<(), RenderError> {
    if layout.channels == 1 {
        return Ok(());
    }
    Err(RenderError::Unsupported(format!(
        "transfer functions classify scalar volumes; this one has {} channels",
        layout.channels
    )))
}
