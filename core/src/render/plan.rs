//! Passes as data: what a renderer asks of a device, without naming one.

pub use cvr_shaders::Template;

use super::LayerPass;
use crate::shader::BindingKind;

/// All passes of one picture, in order. The last one fills the image.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Passes.
    pub passes: Vec<Pass>,
}

/// One pass.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Pass {
    /// A compute shader over the image.
    Compute(ComputePass),
    /// Triangles that are blended into the image.
    Raster(RasterPass),
    /// The same, piece by piece, from a ring of layers that are decoded in between.
    Layers(LayerPass),
}

impl Pass {
    /// The modules that make up its template.
    #[must_use]
    pub fn templates(&self) -> &[Template] {
        match self {
            Self::Compute(pass) => &pass.templates,
            Self::Raster(pass) | Self::Layers(LayerPass { raster: pass, .. }) => &pass.templates,
        }
    }

    /// The entry point that reads voxels.
    #[must_use]
    pub const fn entry(&self) -> &'static str {
        match self {
            Self::Compute(pass) => pass.entry,
            Self::Raster(pass) | Self::Layers(LayerPass { raster: pass, .. }) => pass.fragment,
        }
    }

    /// What it reads, but for voxels.
    #[must_use]
    pub fn inputs(&self) -> &[Input] {
        match self {
            Self::Compute(pass) => &pass.inputs,
            Self::Raster(pass) | Self::Layers(LayerPass { raster: pass, .. }) => &pass.inputs,
        }
    }

    /// The bindings that its template uses.
    #[must_use]
    pub fn bindings(&self) -> Vec<BindingKind> {
        match self {
            Self::Compute(pass) => pass.bindings(),
            Self::Raster(_) | Self::Layers(_) => {
                self.inputs().iter().map(|input| input.kind.clone()).collect()
            }
        }
    }
}

/// What a pass reads, but for voxels.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// How the generator binds it.
    pub kind: BindingKind,
    /// What it holds, in WGSL's layout.
    pub contents: Vec<u8>,
}

/// A compute pass that fills the image, which is bound as `image: array<vec4<f32>>` (premultiplied RGBA in rows,
/// written).
#[derive(Clone, Debug, PartialEq)]
pub struct ComputePass {
    /// The modules that make up the template; one of them declares the entry point.
    pub templates: Vec<Template>,
    /// Entry point.
    pub entry: &'static str,
    /// What it reads.
    pub inputs: Vec<Input>,
    /// Workgroups along x, y, z.
    pub workgroups: [u32; 3],
    /// Whether it follows rays, and how.
    pub rays: Rays,
}

/// How a compute pass follows the rays of its pixels.
///
/// A device may end loops that take it too many rounds and go on behind them (llvmpipe does after 65536 in sum). A pass
/// that follows rays at once marks a pixel of which that is so: an opacity of −1, as red the number of the sample that the
/// ray had come to, and as green 1 where it was not at its end, and 0 where it was and its samples may be wrong. In pieces the same pass is dispatched again and again: each dispatch takes every ray some
/// samples further, from what the picture and `progress` hold of it, to the same picture in every bit.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Rays {
    /// It follows none, or only at once.
    None,
    /// To their ends. It can follow them in pieces, one of its modules being replaced by another.
    AtOnce {
        /// The module, one of [`ComputePass::templates`].
        module: Template,
        /// What takes its place.
        in_pieces: Template,
    },
    /// In pieces. It binds [`BindingKind::Pieces`] and [`BindingKind::Progress`] as well, whose words are of each pixel the
    /// sample that comes next: 0 before the first piece, [`Rays::END`] and [`Rays::CUT`] behind the last.
    InPieces,
}

impl Rays {
    /// The ray has come to its end.
    pub const END: u32 = 0xffff_ffff;
    /// The device ended loops of a piece before they were done.
    pub const CUT: u32 = 0xffff_fffe;
}

impl ComputePass {
    /// The bindings that its template uses.
    #[must_use]
    pub fn bindings(&self) -> Vec<BindingKind> {
        let written: &[BindingKind] = match self.rays {
            Rays::InPieces => &[BindingKind::Image, BindingKind::Progress, BindingKind::Pieces],
            Rays::None | Rays::AtOnce { .. } => &[BindingKind::Image],
        };
        self.inputs.iter().map(|input| &input.kind).chain(written).cloned().collect()
    }

    /// The same pass with its rays in pieces; `None` where it cannot have that.
    #[must_use]
    pub fn in_pieces(&self) -> Option<Self> {
        let Rays::AtOnce { module, in_pieces } = self.rays else { return None };
        let templates = self.templates.iter().map(|t| if *t == module { in_pieces } else { *t });
        Some(Self { templates: templates.collect(), rays: Rays::InPieces, ..self.clone() })
    }
}

/// A pass that draws triangles one after the other, each *over* what is there, into an image that is transparent at
/// first. The fragment shader returns premultiplied RGBA.
#[derive(Clone, Debug, PartialEq)]
pub struct RasterPass {
    /// The modules that make up the template; they declare both entry points.
    pub templates: Vec<Template>,
    /// Entry point of the vertex shader, which takes a [`ProxyVertex`] at locations 0 and 1.
    pub vertex: &'static str,
    /// Entry point of the fragment shader.
    pub fragment: &'static str,
    /// What the fragment shader reads.
    pub inputs: Vec<Input>,
    /// Corners of triangles, the farthest triangle first.
    pub vertices: Vec<ProxyVertex>,
    /// What sums are kept in.
    pub blending: Blending,
}

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
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum Blending {
    /// Half precision: what every device can blend. Its eleven bits are rounded at each slice.
    Float16,
    /// Single precision; half where a device cannot blend it, which the record tells.
    #[default]
    Float32,
}
