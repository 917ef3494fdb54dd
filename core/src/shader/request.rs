//! What the generator is asked, and what it answers.

use super::{Form, Program, Segment};
use crate::codec::{Constant, DecodedForm, Resource, WgslModule};
use crate::render::{Filter, Template};
use crate::volume::{Axis, FrameIndex, Level, VolumeLayout};

/// What a shader is to be made of.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// The shader but for its voxels.
    pub program: &'a Program,
    /// Shape of the volume.
    pub layout: &'a VolumeLayout,
    /// Where voxels come from.
    pub source: Source<'a>,
    /// How values between voxels come about; `None` for a template that only fetches voxels.
    pub filter: Option<Filter>,
    /// What the device can bind.
    pub limits: BindingLimits,
}

/// Where the template's voxels come from.
#[derive(Clone, Debug)]
pub enum Source<'a> {
    /// Decoded at every fetch.
    Inline {
        /// Codec id.
        codec: &'a str,
        /// The snippet.
        module: WgslModule<'a>,
        /// Its buffers.
        resources: Vec<ResourceSize>,
        /// Frame, resolution and stages to decode.
        frame: FrameIndex,
        /// Resolution and stages to decode.
        level: Level,
    },
    /// Rebuilt before by a codec's own passes, in a scratch buffer of theirs.
    Frame {
        /// Index of the buffer among the scratch buffers.
        buffer: usize,
        /// Its words.
        words: u64,
    },
    /// Decoded before, layer by layer, into a 3-D texture of four layers ([`crate::render::LayerStep`]).
    Ring {
        /// Texel format, scale and offset.
        form: DecodedForm,
        /// Who filters.
        sampling: TextureSampling,
        /// What layers lie across.
        axis: Axis,
    },
    /// Held in buffers of words, from which modules of the holder's own fetch voxels.
    Buffers {
        /// What the names of constants and accessors begin with.
        name: &'a str,
        /// The modules. One of them declares `voxel_fetch(p: vec3<i32>) -> Voxel`.
        modules: &'a [Template],
        /// Constants that the generator declares as `<name>_<constant>`.
        constants: Vec<Constant>,
        /// The buffers, whose words the modules read as `<name>_<buffer>(i)`.
        buffers: Vec<ResourceSize>,
    },
    /// Decoded before, into a 3-D texture.
    Texture {
        /// Texel format, scale and offset.
        form: DecodedForm,
        /// Who filters.
        sampling: TextureSampling,
        /// Texels along each axis, where they are more than voxels: a format of blocks holds whole ones.
        padded: Option<[u32; 3]>,
    },
}

/// Who filters a texture.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum TextureSampling {
    /// The texture unit: the format must be filterable on the device.
    Hardware,
    /// The shader, from single texels.
    Manual,
}

/// Size of one buffer of a codec.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct ResourceSize {
    /// Name without the codec's prefix.
    pub name: &'static str,
    /// 32-bit words; 0 is bound as one zero word.
    pub words: u64,
}

impl ResourceSize {
    /// That of a codec's buffer.
    #[must_use]
    pub fn of(resource: &Resource<'_>) -> Self {
        Self { name: resource.name, words: resource.words.len() as u64 }
    }
}

/// What a device can bind.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct BindingLimits {
    /// Words in one storage binding; a larger buffer is split over several.
    pub storage_words: u64,
    /// Storage buffers in one shader stage.
    pub storage_buffers: u32,
}

impl Default for BindingLimits {
    /// What every WebGPU device offers.
    fn default() -> Self {
        Self { storage_words: (128 << 20) / 4, storage_buffers: 8 }
    }
}

/// What a binding holds.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum BindingKind {
    /// The struct `inputs` of all uniforms.
    Uniforms(Vec<UniformMember>),
    /// A storage buffer of the program.
    Storage {
        /// Its name.
        name: &'static str,
        /// Whether it is bound to be written.
        written: bool,
    },
    /// A 2-D texture of the program, in single precision.
    Table {
        /// Its name.
        name: &'static str,
        /// Its rows.
        rows: u32,
    },
    /// Read-only storage: words `first..first + words` of a codec's buffer.
    Words {
        /// Index of the buffer among the codec's resources.
        resource: usize,
        /// First word of this part.
        first: u64,
        /// Words of this part.
        words: u64,
    },
    /// Storage: words `first..first + words` of a scratch buffer of a codec's passes.
    Scratch {
        /// Index of the buffer among the scratch buffers.
        buffer: usize,
        /// First word of this part.
        first: u64,
        /// Words of this part.
        words: u64,
        /// Whether it is bound to be written.
        written: bool,
    },
    /// 3-D texture of the decoded volume, one or (RGB) four channels.
    VolumeTexture {
        /// Whether it is bound as filterable.
        filterable: bool,
    },
    /// Clamping linear sampler for the volume texture.
    VolumeSampler,
    /// The same for a ring of layers, which it repeats along the texture's third axis.
    RingSampler,
}

impl BindingKind {
    /// Whether it is a storage buffer.
    #[must_use]
    pub const fn is_storage(&self) -> bool {
        match self {
            Self::Storage { .. } | Self::Words { .. } | Self::Scratch { .. } => true,
            Self::Uniforms(_)
            | Self::Table { .. }
            | Self::VolumeTexture { .. }
            | Self::VolumeSampler
            | Self::RingSampler => false,
        }
    }
}

/// A uniform in the buffer of all.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub struct UniformMember {
    /// Name.
    pub name: &'static str,
    /// First byte.
    pub offset: u32,
    /// Bytes of its struct.
    pub bytes: u32,
}

/// One binding of a generated shader.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Binding {
    /// `@group`: 0 for the template, 1 for the voxel source.
    pub group: u32,
    /// `@binding`.
    pub binding: u32,
    /// What it holds.
    pub kind: BindingKind,
}

/// A parsed and validated shader.
#[derive(Clone, Debug)]
pub struct GeneratedShader {
    /// The whole text, each part under a comment that names its origin.
    pub wgsl: String,
    /// Where each part of the text comes from.
    pub segments: Vec<Segment>,
    /// Its bindings in order of group and number.
    pub bindings: Vec<Binding>,
    /// Entry point.
    pub entry: String,
    /// How often the voxel source stands in the text once calls are replaced by what they call.
    pub form: Form,
    /// Statements and expressions that are left of the text then, those in inner loops of the decoder counted eightfold: what it
    /// takes a software rasteriser to compile.
    pub inlined_operations: u64,
}

/// The text of a shader before it is proven, with its bindings. Equal drafts make equal shaders.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Draft {
    pub(super) wgsl: String,
    pub(super) bindings: Vec<Binding>,
    pub(super) entry: String,
}
