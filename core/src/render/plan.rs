//! Passes as data: what a renderer asks of a device, without naming one.

pub use cvr_shaders::Template;

use crate::shader::BindingKind;

/// All passes of one picture, in order. The last one fills the image.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Passes.
    pub passes: Vec<Pass>,
    /// Straight RGBA entries that templates read as `transfer_table`.
    pub transfer_table: Vec<[f32; 4]>,
}

/// One pass.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Pass {
    /// A compute shader over the image.
    Compute(ComputePass),
}

/// A compute pass that fills the image.
///
/// The generator binds for it what `bindings` lists: `view` (uniform of the struct `View`, which a template
/// declares), `transfer_table: array<vec4<f32>>` (read), `image: array<vec4<f32>>` (premultiplied RGBA in rows,
/// written), and whatever the voxel source needs.
#[derive(Clone, Debug, PartialEq)]
pub struct ComputePass {
    /// The modules that make up the template; one of them declares the entry point.
    pub templates: Vec<Template>,
    /// Entry point.
    pub entry: &'static str,
    /// The bindings that the template uses.
    pub bindings: &'static [BindingKind],
    /// Bytes of the uniform `view`, in WGSL's layout.
    pub view: Vec<u8>,
    /// Workgroups along x, y, z.
    pub workgroups: [u32; 3],
}
