//! Passes as data: what a renderer asks of a device, without naming one.

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

/// One pass: what is compiled, and what may change from picture to picture without that.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// What is compiled. Over the same volume equal pipelines are compiled once.
    pub pipeline: Pipeline,
    /// What it reads and how much of it runs.
    pub inputs: Inputs,
}

/// What decides the shaders of a pass and the state of the device beside them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Pipeline {
    /// What the modules are run by.
    pub stage: Stage,
    /// The renderer's own modules.
    pub modules: Vec<Module>,
    /// Modules that stand in the text where something uses what they declare ([`Program::offered`]).
    pub offered: Vec<Module>,
    /// What modules may read beside voxels; of each that one uses the inputs hold the contents.
    pub variables: Vec<Variable>,
}

/// What runs the modules of a pass. Entry points that the modules do not declare themselves are the engine's: they also
/// guard against devices that end loops before they are done (llvmpipe does after 65535 rounds in sum), which no renderer
/// needs to know of.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// A compute shader of the renderer's own, which fills `image: array<vec4<f32>>` (premultiplied RGBA in rows).
    Compute {
        /// Entry point, which a module declares.
        entry: &'static str,
    },
    /// Rays that are followed through the drawn box, a pixel each. A module declares
    /// `gather(so_far: vec4<f32>, x: vec3<f32>, direction: vec3<f32>, piece: f32) -> Gathered`: what a ray has gathered once
    /// it has taken the sample at `x`, which stands for `piece` voxel lengths of it, and whether it ends there.
    Rays(RayWalk),
    /// Triangles that are drawn one after the other, each *over* what is there, into an image that is transparent at first. A
    /// module declares `shown(proxy: Proxy) -> vec4<f32>`, the premultiplied RGBA of a fragment, and the struct `Proxy`.
    Triangles(Proxies),
    /// The same, piece by piece, from a ring of layers that are decoded in between ([`LayerStep`]). The instance that
    /// the vertex shader is drawn with is [`LayerStep::Draw::between`] plus 1.
    Layers {
        /// The triangles.
        proxies: Proxies,
        /// What layers lie across.
        axis: Axis,
    },
}

/// What follows rays. Rays that are followed at once mark a pixel where the device has ended loops: an opacity of −1, as red
/// the number of the sample that the ray had come to, and as green 1 where it was not at its end, and 0 where it was and
/// its samples may be wrong. Rays in pieces are followed some samples further by each of many dispatches, from what the
/// picture and `progress` hold of them, to the same picture in every bit.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub struct RayWalk {
    /// The module that follows them to their ends.
    pub at_once: Template,
    /// What takes its place for rays in pieces. It uses `inputs.pieces` and `progress`, whose words are of each pixel the
    /// sample that comes next: 0 before the first piece, [`RayWalk::END`] and [`RayWalk::CUT`] behind the last.
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
    /// The device ended loops of a piece before they were done.
    pub const CUT: u32 = 0xffff_fffe;
    /// Pixels along x and y that a workgroup follows rays of.
    pub const WORKGROUP: u32 = 8;
}

/// Triangles of a pass, but for their corners.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Proxies {
    /// Entry point of the vertex shader, which a module declares. It takes a [`ProxyVertex`] at locations 0 and 1.
    pub vertex: &'static str,
    /// What sums are kept in.
    pub blending: Blending,
}

/// What a pass reads beside voxels, and how much of it runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inputs {
    /// Contents of the pipeline's variables.
    pub contents: Vec<Contents>,
    /// Workgroups along x, y, z of [`Stage::Compute`].
    pub workgroups: [u32; 3],
    /// Corners of triangles, the farthest triangle first, of [`Stage::Triangles`] and [`Stage::Layers`].
    pub vertices: Vec<ProxyVertex>,
    /// What [`Stage::Layers`] does, in this order, into an image that is transparent at first. A slot is read only once
    /// it is filled.
    pub steps: Vec<LayerStep>,
}

/// What a variable holds, in WGSL's layout.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// Name of the variable.
    pub name: &'static str,
    /// Bytes.
    pub bytes: Vec<u8>,
}

impl Pipeline {
    /// The program that draws where a device runs loops to their ends, or shows where it does not.
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

    /// The program that draws the same where a device ends loops: rays in pieces, and fragments that paint a red below
    /// zero where loops were ended. `None` where there is none.
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

    /// What layers lie across, where it draws layer by layer.
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

/// What blended sums are kept in.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Hash)]
pub enum Blending {
    /// Half precision: what every device can blend. Its eleven bits are rounded at each slice.
    Float16,
    /// Single precision; half where a device cannot blend it, which the record tells.
    #[default]
    Float32,
}
