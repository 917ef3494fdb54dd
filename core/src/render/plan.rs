//! Passes as data: a renderer's request to a device.

use cvr_shaders as shaders;
pub use cvr_shaders::Template;

use super::LayerStep;
use crate::shader::{Module, Program, Variable};
use crate::volume::Axis;

/// All passes of one picture, in order. The last one fills the image.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Passes.
    pub passes: Vec<Pass>,
}

/// One pass: the pipeline to compile, and inputs that may change from picture to picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// The compiled part. Equal pipelines over the same volume are compiled once.
    pub pipeline: Pipeline,
    /// The data that it reads, and how much of it runs.
    pub inputs: Inputs,
}

/// Everything that determines the shaders of a pass, and the device state for them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Pipeline {
    /// How the modules run.
    pub stage: Stage,
    /// The renderer's own modules.
    pub modules: Vec<Module>,
    /// Modules that the text includes if a module uses their declarations ([`Program::offered`]).
    pub offered: Vec<Module>,
    /// Variables that modules may read. The inputs hold the contents of each used variable.
    pub variables: Vec<Variable>,
}

/// How the modules of a pass run. If the modules declare no entry point, the engine provides one. The engine also
/// guards against devices that end loops early (llvmpipe, after 65535 rounds in sum). Renderers need no code for this.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// A compute shader of the renderer's own. It fills `image: array<vec4<f32>>` (premultiplied RGBA in rows).
    Compute {
        /// Entry point, which a module declares.
        entry: &'static str,
    },
    /// Rays through the drawn box, one per pixel. A module declares `gather(so_far: vec4<f32>, x: vec3<f32>, direction:
    /// vec3<f32>, piece: f32) -> Gathered`. It adds the ray sample at `x`, which stands for `piece` voxel lengths of
    /// the ray, and decides whether the ray ends.
    Rays(RayWalk),
    /// Triangles, each drawn *over* the earlier ones, into an image that is transparent at first. A module declares
    /// `shown(proxy: Proxy) -> vec4<f32>`, the premultiplied RGBA of a fragment, and the struct `Proxy`.
    Triangles(Proxies),
    /// The same in pieces, from a ring of layers that are decoded between the pieces ([`LayerStep`]). The instance
    /// index of the vertex shader is [`LayerStep::Draw::between`] plus 1.
    Layers {
        /// The triangles.
        proxies: Proxies,
        /// What layers lie across.
        axis: Axis,
    },
}

/// The modules that follow rays. The module `at_once` marks a pixel if the device has ended a loop: opacity −1; red is
/// the number of the ray's last sample; green is 1 if the ray was not at its end, and 0 if it was but its samples may
/// be wrong. The module `in_pieces` follows rays over many dispatches, some samples each. It continues from the picture
/// and `progress`, and makes the same picture in every bit.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub struct RayWalk {
    /// The module that follows them to their ends.
    pub at_once: Template,
    /// The module for rays in pieces. It uses `inputs.pieces` and `progress`. `progress` holds one word per pixel, the
    /// number of the next sample: 0 before the first piece, [`RayWalk::END`] or [`RayWalk::CUT`] after the last.
    pub in_pieces: Template,
}

impl Default for RayWalk {
    fn default() -> Self {
        Self { at_once: shaders::RAYS_AT_ONCE, in_pieces: shaders::RAYS_IN_PIECES }
    }
}

impl RayWalk {
    /// The ray has come to its end.
    pub const END: u32 = 0xffff_ffff;
    /// The device ended the loops of a piece early.
    pub const CUT: u32 = 0xffff_fffe;
    /// Edge of a workgroup in pixels, along x and y.
    pub const WORKGROUP: u32 = 8;
}

/// Triangles of a pass, without their vertices.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Proxies {
    /// Entry point of the vertex shader, which a module declares. It takes a [`ProxyVertex`] at locations 0 and 1.
    pub vertex: &'static str,
    /// Precision of the sums.
    pub blending: Blending,
}

/// Data that a pass reads besides voxels, and how much of the pass runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inputs {
    /// Contents of the pipeline's variables.
    pub contents: Vec<Contents>,
    /// Workgroups along x, y, z of [`Stage::Compute`].
    pub workgroups: [u32; 3],
    /// Corners of triangles, the farthest triangle first, for [`Stage::Triangles`] and [`Stage::Layers`].
    pub vertices: Vec<ProxyVertex>,
    /// The steps of [`Stage::Layers`], in order, into an image that is transparent at first. A slot is read only after
    /// it was filled.
    pub steps: Vec<LayerStep>,
}

/// The content of a variable, in WGSL's layout.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// Name of the variable.
    pub name: &'static str,
    /// Bytes.
    pub bytes: Vec<u8>,
}

impl Pipeline {
    /// The program for devices that run loops to their ends. On other devices it marks the affected pixels.
    #[must_use]
    pub fn program(&self) -> Program {
        match self.stage {
            Stage::Compute { entry } => self.driven(&[], entry, &[IMAGE]),
            Stage::Rays(walk) => self.driven(&[shaders::FOLLOW_RAYS, walk.at_once], "follow_rays", &[IMAGE]),
            Stage::Triangles(_) | Stage::Layers { .. } => {
                self.driven(&[shaders::BLENDED_UNCHECKED], "blended", &[])
            }
        }
    }

    /// The program for devices that end loops early: rays in pieces, and fragments that write a negative red if a loop
    /// was ended. `None` if there is none.
    #[must_use]
    pub fn guarded_program(&self) -> Option<Program> {
        match self.stage {
            Stage::Compute { .. } => None,
            Stage::Rays(walk) => {
                let pieces = Variable::Uniform { name: "pieces", wgsl_type: "Pieces" };
                let variables = [IMAGE, Variable::written("progress", "array<u32>"), pieces];
                Some(self.driven(&[shaders::FOLLOW_RAYS, walk.in_pieces], "follow_rays", &variables))
            }
            Stage::Triangles(_) | Stage::Layers { .. } => {
                Some(self.driven(&[shaders::BLENDED_CHECKED], "blended", &[]))
            }
        }
    }

    /// The triangles that it draws, if it does.
    #[must_use]
    pub const fn proxies(&self) -> Option<Proxies> {
        match self.stage {
            Stage::Compute { .. } | Stage::Rays(_) => None,
            Stage::Triangles(proxies) | Stage::Layers { proxies, .. } => Some(proxies),
        }
    }

    /// The axis across which it draws layer by layer, if it does.
    #[must_use]
    pub const fn layers(&self) -> Option<Axis> {
        match self.stage {
            Stage::Layers { axis, .. } => Some(axis),
            Stage::Compute { .. } | Stage::Rays(_) | Stage::Triangles(_) => None,
        }
    }

    fn driven(&self, drivers: &[Template], entry: &'static str, variables: &[Variable]) -> Program {
        let drivers = drivers.iter().copied().map(Module::from);
        Program {
            modules: drivers.chain(self.modules.iter().cloned()).collect(),
            offered: self.offered.clone(),
            entry,
            variables: self.variables.iter().chain(variables).copied().collect(),
        }
    }
}

/// What compute passes fill.
const IMAGE: Variable = Variable::written("image", "array<vec4<f32>>");

/// A corner of proxy geometry.
#[derive(Copy, Clone, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct ProxyVertex {
    /// In the picture, from −1 (left, bottom) to 1 (right, top).
    pub position: [f32; 2],
    /// The slice that the triangle belongs to.
    pub slice: u32,
}

/// Precision of blended sums.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Hash)]
pub enum Blending {
    /// Half precision, which every device can blend. Its eleven bits are rounded at each slice.
    Float16,
    /// Single precision. Half precision if a device cannot blend single; the record then says so.
    #[default]
    Float32,
}
