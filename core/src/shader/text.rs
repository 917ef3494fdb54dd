//! The growing text of a shader, and the parts that the generator writes itself.

use std::fmt::Write as _;

use cvr_shaders::Template;

use super::request::UniformMember;
use super::{Binding, BindingKind, Module, Origin, Segment, ShaderError, Variable};
use crate::codec::{Constant, ConstantValue, DecodedForm};
use crate::render::RING_LAYERS;
use crate::volume::{Axis, FrameIndex, Level, VolumeLayout};

/// The growing text, with the origin of every part.
#[derive(Default)]
pub struct Text {
    pub wgsl: String,
    pub segments: Vec<Segment>,
}

impl Text {
    /// Appends a file as it stands, under a comment that names it.
    pub fn file(&mut self, file: &str, source: &str, snippet: bool) {
        self.part(file, source, Origin::File { file: file.to_owned(), snippet });
    }

    /// Appends a template.
    pub fn template(&mut self, template: Template) {
        self.file(template.file, template.source, false);
    }

    /// Appends a module.
    pub fn module(&mut self, module: &Module) {
        match module {
            Module::File(template) => self.template(*template),
            Module::Generated { purpose, source } => self.generated(purpose, source),
        }
    }

    /// Appends text of the generator, unless it is empty.
    pub fn generated(&mut self, purpose: &str, source: &str) {
        if !source.is_empty() {
            self.part(
                &format!("generated: {purpose}"),
                source,
                Origin::Generated { purpose: purpose.to_owned() },
            );
        }
    }

    fn part(&mut self, title: &str, source: &str, origin: Origin) {
        if !self.wgsl.is_empty() {
            self.wgsl.push('\n');
        }
        // A plugin may have chosen the title. It must not end its comment.
        let title: String = title.chars().map(|c| if c.is_control() { '?' } else { c }).collect();
        let _ = writeln!(self.wgsl, "// ==== {title}");
        let start = self.wgsl.len();
        self.wgsl.push_str(source);
        self.segments.push(Segment { range: start..self.wgsl.len(), origin });
        if !source.ends_with('\n') {
            self.wgsl.push('\n');
        }
    }
}

/// Extent of the volume.
pub fn volume_constants(layout: &VolumeLayout) -> String {
    let [x, y, z] = layout.extent.to_array();
    format!("const volume_extent = vec3<u32>({x}u, {y}u, {z}u);\n")
}

/// Scale and offset of a texture's texels.
pub fn texel_constants(form: DecodedForm) -> String {
    format!("const texel_scale: f32 = {:?};\nconst texel_offset: f32 = {:?};\n", form.scale, form.offset)
}

/// Size of a texture that is larger than the volume.
pub fn texture_size([x, y, z]: [u32; 3]) -> String {
    format!("const texture_size = vec3<u32>({x}u, {y}u, {z}u);\n")
}

/// Constants of a codec, under its prefix.
pub fn codec_constants(codec: &str, constants: &[Constant]) -> Result<String, ShaderError> {
    let mut text = String::new();
    for Constant { name, value } in constants {
        let value = match value {
            ConstantValue::U32(v) => format!("u32 = {v}u"),
            // `{:?}` prints the shortest text that reads back as the same number.
            ConstantValue::F32(v) if v.is_finite() => format!("f32 = {v:?}"),
            ConstantValue::F32(v) => {
                return Err(ShaderError(format!(
                    "constant `{codec}_{name}` is {v}: WGSL has no such number"
                )));
            }
            ConstantValue::Vec3U32([x, y, z]) => format!("vec3<u32> = vec3<u32>({x}u, {y}u, {z}u)"),
        };
        let _ = writeln!(text, "const {codec}_{name}: {value};");
    }
    Ok(text)
}

/// Functions about the frame and level that a snippet may call. Only those that it calls are written.
pub fn level_accessors(codec: &str, snippet: &str, frame: FrameIndex, level: Level) -> String {
    let values = [
        ("frame", frame.0),
        ("resolution", u32::from(level.resolution)),
        ("stages", u32::from(level.stages)),
    ];
    let mut text = String::new();
    for (name, value) in values {
        let function = format!("{codec}_{name}");
        if snippet.contains(&format!("{function}(")) {
            let _ = writeln!(text, "fn {function}() -> u32 {{\n    return {value}u;\n}}");
        }
    }
    text
}

/// Declarations of a program's variables, in group 0: all uniforms in one buffer.
pub fn variables(variables: &[Variable]) -> (String, Vec<Binding>) {
    let (mut text, mut bindings) = (String::new(), Vec::new());
    let uniforms: Vec<_> = variables
        .iter()
        .filter_map(|variable| match variable {
            Variable::Uniform { name, wgsl_type } => Some((*name, *wgsl_type)),
            Variable::Storage { .. } | Variable::Table { .. } => None,
        })
        .collect();
    if !uniforms.is_empty() {
        text.push_str("struct Inputs {\n");
        for (name, wgsl_type) in &uniforms {
            // The uniform address space requires this for nested structs.
            let _ = writeln!(text, "    @align(16) {name}: {wgsl_type},");
        }
        text.push_str("}\n@group(0) @binding(0) var<uniform> inputs: Inputs;\n");
        // The offsets of members are read from the parsed text later.
        let members = uniforms.iter().map(|&(name, _)| UniformMember { name, offset: 0, bytes: 0 });
        bindings.push(Binding { group: 0, binding: 0, kind: BindingKind::Uniforms(members.collect()) });
    }
    for variable in variables {
        let binding = bindings.len() as u32;
        let (declaration, kind) = match *variable {
            Variable::Uniform { .. } => continue,
            Variable::Storage { name, wgsl_type, written } => {
                let access = if written { "read_write" } else { "read" };
                (
                    format!("var<storage, {access}> {name}: {wgsl_type}"),
                    BindingKind::Storage { name, written },
                )
            }
            Variable::Table { name, rows } => {
                (format!("var {name}: texture_2d<f32>"), BindingKind::Table { name, rows })
            }
        };
        let _ = writeln!(text, "@group(0) @binding({binding}) {declaration};");
        bindings.push(Binding { group: 0, binding, kind });
    }
    (text, bindings)
}

/// Bindings of the decoded volume's texture, in group 1, with a sampler for hardware filtering.
pub fn texture_bindings(sampler: Option<BindingKind>) -> (String, Vec<Binding>) {
    let mut text = "@group(1) @binding(0) var volume_texture: texture_3d<f32>;\n".to_owned();
    let texture = BindingKind::VolumeTexture { filterable: sampler.is_some() };
    let mut bindings = vec![Binding { group: 1, binding: 0, kind: texture }];
    if let Some(kind) = sampler {
        text.push_str("@group(1) @binding(1) var volume_sampler: sampler;\n");
        bindings.push(Binding { group: 1, binding: 1, kind });
    }
    (text, bindings)
}

/// Positions in layers across an axis: along rows, across rows, and the layer. Only called functions are written.
pub fn layer_places(axis: Axis, calls: impl Fn(&str) -> bool) -> String {
    let there = axis.layered(["x", "y", "z"]).concat();
    let back = axis.unlayered(["x", "y", "z"]).concat();
    let mut text = String::new();
    for (function, kind, swizzle) in
        [("layered", "f32", &there), ("layered_voxel", "i32", &there), ("voxel_of_layer", "i32", &back)]
    {
        if calls(&format!("{function}(")) {
            let _ = writeln!(
                text,
                "fn {function}(p: vec3<{kind}>) -> vec3<{kind}> {{\n    return p.{swizzle};\n}}"
            );
        }
    }
    text
}

/// The size of the ring, and positions in its layers.
pub fn ring(axis: Axis, calls: impl Fn(&str) -> bool) -> String {
    format!("const ring_layers: i32 = {RING_LAYERS};\n{}", layer_places(axis, calls))
}

/// `voxel_fetch` and `voxel_cell` over a codec's snippet. Only called functions are written.
pub fn inline_source(codec: &str, fetch: bool, cell: bool) -> String {
    let mut text = String::new();
    if fetch {
        let _ = writeln!(
            text,
            "fn voxel_fetch(p: vec3<i32>) -> Voxel {{\n    return voxel_of({codec}_fetch(p));\n}}"
        );
    }
    if cell {
        let _ = writeln!(
            text,
            "fn voxel_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {{\n    return \
             {codec}_fetch_cell(p, q);\n}}"
        );
    }
    text
}
