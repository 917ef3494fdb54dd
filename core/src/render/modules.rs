//! The modules that a view needs of every renderer's shader, and no more.

use cvr_shaders as shaders;

use super::uniforms::{ClipUniform, ColourUniform, LightingUniform, ViewUniform, uniform_bytes};
use super::{ColourOpacity, Input, Projection, RayFrame, RenderError, Template, View};
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
    /// When a uniform cannot be laid out.
    pub fn new(view: &View, layout: &VolumeLayout) -> Result<Self, RenderError> {
        let rays = view.rays(layout);
        let camera = match view.camera.projection {
            Projection::Perspective => shaders::CAMERA_PERSPECTIVE,
            Projection::Orthographic => shaders::CAMERA_ORTHOGRAPHIC,
        };
        let mut modules = Self { templates: vec![shaders::VIEW, camera], inputs: Vec::new() };
        modules.read(BindingKind::View, uniform_bytes(&ViewUniform::new(view, &rays))?);
        modules.bounds(view, layout)?;
        modules.classification(view, layout)?;
        modules.optics(view, layout, &rays)?;
        if let Some(macrocells) = view.skippable(layout) {
            modules.templates.push(shaders::MACROCELLS);
            modules.read(BindingKind::Macrocells, bytemuck::cast_slice(macrocells.words()).to_vec());
        }
        Ok(modules)
    }

    fn read(&mut self, kind: BindingKind, contents: Vec<u8>) {
        self.inputs.push(Input { kind, contents });
    }

    fn bounds(&mut self, view: &View, layout: &VolumeLayout) -> Result<(), RenderError> {
        if view.draws_whole(layout.extent) {
            self.templates.push(shaders::BOUNDS_WHOLE);
            return Ok(());
        }
        self.templates.push(shaders::BOUNDS_CLIP);
        self.read(BindingKind::Clip, uniform_bytes(&ClipUniform::new(view.bounds(layout.extent)))?);
        Ok(())
    }

    fn classification(&mut self, view: &View, layout: &VolumeLayout) -> Result<(), RenderError> {
        let is_colour = layout.channels != 1;
        if is_colour {
            self.templates.push(shaders::COLOUR);
            self.read(BindingKind::Colour, uniform_bytes(&ColourUniform::new(view, layout.sample))?);
        }
        if let (true, ColourOpacity::Table(table)) = (is_colour, &view.colour_opacity) {
            self.templates.push(shaders::CLASSIFY_COLOUR_TABLE);
            self.read(BindingKind::OpacityTable, bytemuck::cast_slice(table.numbers()).to_vec());
            return Ok(());
        }
        self.templates.push(shaders::TRANSFER);
        if is_colour {
            self.templates.extend([shaders::CLASSIFY_COLOUR_TRANSFER, shaders::HEIGHT_COLOUR]);
        } else {
            self.templates.push(shaders::CLASSIFY_SCALAR);
        }
        let function = &view.transfer_function;
        let table = bytemuck::cast_slice(&function.table()).to_vec();
        self.read(BindingKind::TransferTable, table);
        self.read(BindingKind::TransferSegments(function.search()), Vec::new());
        Ok(())
    }

    fn optics(&mut self, view: &View, layout: &VolumeLayout, rays: &RayFrame) -> Result<(), RenderError> {
        let Some(shading) = &view.shading else {
            self.templates.push(shaders::OPTICS_UNLIT);
            return Ok(());
        };
        self.templates.extend([shaders::OPTICS_LIT, shaders::GRADIENT, shaders::BLINN_PHONG]);
        // What decides the opacity of a colour is there already.
        let height = if layout.channels == 1 { shaders::HEIGHT_SCALAR } else { shaders::HEIGHT_COLOUR };
        if !self.templates.contains(&height) {
            self.templates.push(height);
        }
        self.read(BindingKind::Lighting, uniform_bytes(&LightingUniform::new(view, shading, rays))?);
        Ok(())
    }
}
