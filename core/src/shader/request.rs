//! Input and output of the generator.

use super::{Form, Program, Segment};
use crate::codec::{Constant, DecodedForm, Resource, WgslModule};
use crate::render::{Filter, Template};
use crate::volume::{Axis, FrameIndex, Level, VolumeLayout};

/// The parts of a shader to generate.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// The shader without its voxel source.
    pub program: &'a Program,
    /// Shape of the volume.
    pub layout: &'a VolumeLayout,
    /// Where voxels come from.
    pub source: Source<'a>,
    /// How values between voxel centres are computed. `None` for a template that only fetches voxels.
    pub filter: Option<Filter>,
    /// Limits of the device's bindings.
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
    /// A frame that the codec's own passes have rebuilt in one of their scratch buffers.
    Frame {
        /// Index of the buffer among the scratch buffers.
        buffer: usize,
        /// Its words.
        words: u64,
    },
    /// Layers decoded before, in a 3-D texture of four layers ([`crate::render::LayerStep`]).
    Ring {
        /// Texel format, scale and offset.
        form: DecodedForm,
        /// Who filters.
        sampling: TextureSampling,
        /// What layers lie across.
        axis: Axis,
    },
    /// Buffers of words. Modules of the source itself fetch voxels from them.
    Buffers {
        /// Prefix of constants and accessors.
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
        /// Texels along each axis, if they are more than the voxels: block formats hold whole blocks.
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
    /// The size of a codec's buffer.
    #[must_use]
    pub fn of(resource: &Resource<'_>) -> Self {
        Self { name: resource.name, words: resource.words.len() as u64 }
    }
}

/// The number and size of buffers that a device can bind.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct BindingLimits {
    /// Words in one storage binding; a larger buffer is split over several.
    pub storage_words: u64,
    /// Storage buffers in one shader stage.
    pub storage_buffers: u32,
}

impl Default for BindingLimits {
    /// The limits that every WebGPU device offers.
    fn default() -> Self {
        Self { storage_words: (128 << 20) / 4, storage_buffers: 8 }
    }
}

/// Content of a binding.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum BindingKind {
    /// The struct `inputs` with all uniforms.
    Uniforms(Vec<UniformMember>),
    /// A storage buffer of the program.
    Storage {
        /// Its name.
        name: &'static str,
        /// Whether it is bound to be written.
        written: bool,
    },
    /// A single-precision 2-D texture of the program.
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
    /// The same for a ring of layers. The sampler repeats along the texture's third axis.
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

/// A uniform inside the shared buffer.
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
    /// Its content.
    pub kind: BindingKind,
}

/// A parsed and validated shader.
#[derive(Clone, Debug)]
pub struct GeneratedShader {
    /// The whole text, each part under a comment that names its origin.
    pub wgsl: String,
    /// The origin of each part of the text.
    pub segments: Vec<Segment>,
    /// Its bindings, ordered by group and number.
    pub bindings: Vec<Binding>,
    /// Entry point.
    pub entry: String,
    /// Number of copies of the voxel source after calls are inlined.
    pub form: Form,
    /// Number of statements and expressions after calls are inlined. Those in inner loops of the decoder count
    /// eightfold. It estimates the compile time of a software rasteriser.
    pub inlined_operations: u64,
}

/// The text of a shader before validation, with its bindings. Equal drafts give equal shaders.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Draft {
    pub(super) wgsl: String,
    pub(super) bindings: Vec<Binding>,
    pub(super) entry: String,
}
