//! The modules that a view offers to every renderer's shader, and the variables that they read.

use cvr_shaders as shaders;
use encase::internal::WriteInto;
use encase::{ShaderSize, ShaderType};

use super::uniforms::{ClipUniform, ColourUniform, LightingUniform, ViewUniform, uniform_bytes};
use super::{
    ColourOpacity, Contents, Inputs, Pass, Pipeline, Projection, RayFrame, RenderError, Stage, Template,
    TransferFunction, View,
};
use crate::shader::{Module, Variable, transfer_segments};
use crate::volume::VolumeLayout;

/// Modules of a view for a renderer: rays, bounds, classification, shading, skipping. A shader contains only those that
/// its renderer uses.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneModules {
    offered: Vec<Module>,
    variables: Vec<Variable>,
    contents: Vec<Contents>,
}

impl SceneModules {
    /// The modules of a view of a volume.
    ///
    /// # Errors
    /// When a uniform cannot be laid out.
    pub fn new(view: &View, layout: &VolumeLayout) -> Result<Self, RenderError> {
        let rays = view.rays(layout);
        let mut scene = Self { offered: Vec::new(), variables: Vec::new(), contents: Vec::new() };
        scene.offer(match view.camera.projection {
            Projection::Perspective => shaders::CAMERA_PERSPECTIVE,
            Projection::Orthographic => shaders::CAMERA_ORTHOGRAPHIC,
        });
        scene.uniform("view", "View", &ViewUniform::new(view, &rays))?;
        scene.bounds(view, layout)?;
        scene.classification(view, layout)?;
        scene.optics(view, &rays)?;
        scene.skipping(view, layout);
        Ok(scene)
    }

    /// Adds a uniform, `inputs.<name>` of the struct `wgsl_type`.
    ///
    /// # Errors
    /// When it cannot be laid out.
    pub fn uniform<T: ShaderType + ShaderSize + WriteInto>(
        &mut self,
        name: &'static str,
        wgsl_type: &'static str,
        value: &T,
    ) -> Result<(), RenderError> {
        self.read(Variable::Uniform { name, wgsl_type }, uniform_bytes(value)?);
        Ok(())
    }

    /// Adds a variable that modules may read, and its content.
    pub fn read(&mut self, variable: Variable, bytes: Vec<u8>) {
        self.variables.push(variable);
        self.contents.push(Contents { name: variable.name(), bytes });
    }

    /// The pass of a renderer, with its own modules. The caller adds workgroups, vertices and steps.
    #[must_use]
    pub fn pass(self, stage: Stage, modules: &[Template]) -> Pass {
        let Self { offered, variables, contents } = self;
        let modules = modules.iter().copied().map(Module::from).collect();
        Pass {
            pipeline: Pipeline { stage, modules, offered, variables },
            inputs: Inputs { contents, ..Inputs::default() },
        }
    }

    fn offer(&mut self, module: impl Into<Module>) {
        self.offered.push(module.into());
    }

    fn bounds(&mut self, view: &View, layout: &VolumeLayout) -> Result<(), RenderError> {
        if view.draws_whole(layout.extent) {
            self.offer(shaders::BOUNDS_WHOLE);
            return Ok(());
        }
        self.offer(shaders::BOUNDS_CLIP);
        self.uniform("clip", "Clip", &ClipUniform::new(view.bounds(layout.extent)))
    }

    fn classification(&mut self, view: &View, layout: &VolumeLayout) -> Result<(), RenderError> {
        let is_colour = layout.channels != 1;
        self.offer(if is_colour { shaders::HEIGHT_COLOUR } else { shaders::HEIGHT_SCALAR });
        if is_colour {
            self.uniform("colour", "Colour", &ColourUniform::new(view, layout.sample))?;
        }
        if let (true, ColourOpacity::Table(table)) = (is_colour, &view.colour_opacity) {
            self.offer(shaders::CLASSIFY_COLOUR_TABLE);
            let numbers = bytemuck::cast_slice(table.numbers()).to_vec();
            self.read(Variable::read("opacity_table", "array<f32>"), numbers);
            return Ok(());
        }
        self.offer(if is_colour { shaders::CLASSIFY_COLOUR_TRANSFER } else { shaders::CLASSIFY_SCALAR });
        let function = &view.transfer_function;
        let rows = TransferFunction::TABLE_ROWS as u32;
        let table = bytemuck::cast_slice(&function.table()).to_vec();
        self.read(Variable::Table { name: "transfer_table", rows }, table);
        self.offer(transfer_segments(function.search()));
        Ok(())
    }

    fn optics(&mut self, view: &View, rays: &RayFrame) -> Result<(), RenderError> {
        let Some(shading) = &view.shading else {
            self.offer(shaders::OPTICS_UNLIT);
            return Ok(());
        };
        self.offer(shaders::OPTICS_LIT);
        self.offer(shaders::GRADIENT);
        self.uniform("lighting", "Lighting", &LightingUniform::new(view, shading, rays))
    }

    fn skipping(&mut self, view: &View, layout: &VolumeLayout) {
        let Some(macrocells) = view.skippable(layout) else {
            self.offer(shaders::EVERY_POINT);
            self.offer(shaders::EVERY_SAMPLE);
            return;
        };
        self.offer(shaders::MACROCELLS);
        self.offer(shaders::NEXT_SAMPLE);
        let words = bytemuck::cast_slice(macrocells.words()).to_vec();
        self.read(Variable::read("macrocells", "array<u32>"), words);
    }
}
