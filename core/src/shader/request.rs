//! What the generator is asked, and what it answers.

use super::{Form, Segment};
use crate::codec::{Constant, DecodedForm, Resource, TexelFormat, WgslModule};
use crate::render::{Filter, SegmentSearch, Template};
use crate::volume::{Axis, FrameIndex, Level, VolumeLayout};

/// What a shader is to be made of.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// The renderer's modules.
    pub templates: &'a [Template],
    /// Entry point that one of them declares.
    pub entry: &'a str,
    /// The bindings that the template uses: any kind but those of voxels, [`BindingKind::Words`],
    /// [`BindingKind::VolumeTexture`], [`BindingKind::VolumeSampler`] and [`BindingKind::RingSampler`].
    pub bindings: &'a [BindingKind],
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
    /// Decoded before, layer by layer, into a 3-D texture of four layers ([`crate::render::LayerPass`]).
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
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BindingKind {
    /// Uniform buffer `view`.
    View,
    /// Uniform `clip`: the struct `Clip` of the box that is drawn.
    Clip,
    /// Uniform `lighting`: the struct `Lighting` of lit samples.
    Lighting,
    /// Uniform `colour`: the struct `Colour` of colour volumes.
    Colour,
    /// Read-only storage `opacity_table: array<f32>`.
    OpacityTable,
    /// Uniform `slabs`: the struct `Slabs` of a stack of slices.
    Slabs,
    /// Read-only storage `macrocells: array<u32>`.
    Macrocells,
    /// 2-D texture `transfer_table` of [`crate::render::TransferFunction::TABLE_ROWS`] rows, in single precision.
    TransferTable,
    /// What finds the segment of a value. It is text, and binds nothing of its own.
    TransferSegments(SegmentSearch),
    /// Storage `image: array<vec4<f32>>`, written.
    Image,
    /// Uniform `pieces`: the struct `Pieces` of rays that are followed piece by piece.
    Pieces,
    /// Storage `progress: array<u32>`, read and written: of each ray the sample that comes next.
    Progress,
    /// Storage `dump_values: array<f32>`, written: voxels of a frame, x fastest, channels interleaved.
    Dump,
    /// Uniform `dumped`: the struct `Dumped`, which voxels these are.
    Dumped,
    /// Uniform `slab`: the struct `Slab` of the template that decodes a frame, in layers across an axis.
    Slab(Axis),
    /// Storage `texels: array<u32>`, written: texels of this format in rows, as a copy into a texture wants them.
    Texels(TexelFormat),
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
    /// The bindings of a template that dumps voxels.
    pub const DUMP: [Self; 2] = [Self::Dump, Self::Dumped];

    /// Whether it is a storage buffer.
    #[must_use]
    pub const fn is_storage(&self) -> bool {
        let is_other = matches!(
            self,
            Self::TransferTable
                | Self::TransferSegments(_)
                | Self::VolumeTexture { .. }
                | Self::VolumeSampler
                | Self::RingSampler
        );
        !is_other && !self.is_uniform()
    }

    /// Whether it is a uniform.
    #[must_use]
    pub const fn is_uniform(&self) -> bool {
        matches!(
            self,
            Self::View
                | Self::Clip
                | Self::Lighting
                | Self::Colour
                | Self::Slabs
                | Self::Slab(_)
                | Self::Pieces
                | Self::Dumped
        )
    }
}

/// One binding of a generated shader.
#[derive(Clone, Debug, PartialEq, Eq)]
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
