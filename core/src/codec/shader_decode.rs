//! How a shader decodes one voxel: a snippet of WGSL, constants, and buffers of words.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::{Block, DecodeError, Decoder};
use crate::volume::{Extent, FrameIndex, Level, SampleType, ValueRange};

/// The WGSL decoder of a codec.
pub trait ShaderDecode: Send + Sync {
    /// The snippet and its constants.
    fn module(&self) -> WgslModule<'_>;

    /// How closely the shader follows the CPU decoder.
    fn agreement(&self) -> Agreement;

    /// The codec's own buffers of one frame, in binding order. The buffers of references follow them
    /// ([`super::References::resources`]).
    ///
    /// # Errors
    /// When the stream lacks one.
    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError>;
}

/// WGSL of a codec: a snippet, or a pass. [`super::FramePass`] states the contract of a pass.
///
/// A snippet declares `<id>_fetch(p: vec3<i32>) -> vec4<f32>`. `p` is in bounds; a scalar is returned in `.x`. It may
/// declare `<id>_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8>`, the corners of the grid cell from `p`
/// to `q`. Both are in bounds, and `q` is `p` or `p + 1` per axis. Corner `i` takes x from bit 0, y from bit 1, z from
/// bit 2 of `i`. All names begin with `<id>_`. There is no `@group`.
#[derive(Clone, Debug)]
pub struct WgslModule<'a> {
    /// Path of the snippet as its author knows it. Errors show it.
    pub file: &'a str,
    /// The text.
    pub source: &'a str,
    /// Constants that the generator declares as `<id>_<name>`.
    pub constants: Vec<Constant>,
}

impl<'a> WgslModule<'a> {
    /// A text without constants.
    #[must_use]
    pub const fn new(file: &'a str, source: &'a str) -> Self {
        Self { file, source, constants: Vec::new() }
    }

    /// The same with one more constant.
    #[must_use]
    pub fn with(mut self, name: &'static str, value: impl Into<ConstantValue>) -> Self {
        self.constants.push(Constant::new(name, value));
        self
    }
}

/// A named constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// Name without the codec's prefix.
    pub name: &'static str,
    /// Value.
    pub value: ConstantValue,
}

impl Constant {
    /// A constant of this name and value.
    #[must_use]
    pub fn new(name: &'static str, value: impl Into<ConstantValue>) -> Self {
        Self { name, value: value.into() }
    }
}

/// Value of a [`Constant`].
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum ConstantValue {
    /// `u32`
    U32(u32),
    /// `f32`; must be finite.
    F32(f32),
    /// `vec3<u32>`
    Vec3U32([u32; 3]),
}

impl From<u32> for ConstantValue {
    fn from(value: u32) -> Self {
        Self::U32(value)
    }
}

impl From<f32> for ConstantValue {
    fn from(value: f32) -> Self {
        Self::F32(value)
    }
}

impl From<Extent> for ConstantValue {
    fn from(extent: Extent) -> Self {
        Self::Vec3U32(extent.to_array())
    }
}

impl From<[u32; 3]> for ConstantValue {
    fn from(value: [u32; 3]) -> Self {
        Self::Vec3U32(value)
    }
}

impl From<Block> for ConstantValue {
    fn from(block: Block) -> Self {
        block.0.into()
    }
}

/// A buffer of 32-bit words. The snippet reads it with `<id>_<name>(i: u32) -> u32`. The generator may split it over
/// several bindings; the snippet does not see this.
#[derive(Clone, Debug)]
pub struct Resource<'a> {
    /// Name without the codec's prefix.
    pub name: &'static str,
    /// The words; an empty buffer is bound as one zero word.
    pub words: Cow<'a, [u32]>,
}

/// Agreement between a shader or texture unit and the CPU decoder.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Agreement {
    /// Equal bit for bit, except that +0 equals −0.
    Exact,
    /// Within this many units in the last place of the largest magnitude in the decoder's `value_range` of the voxel
    /// (of the value itself if the decoder knows no range). A tighter bound is impossible for sums that cancel.
    Ulp(u32),
    /// Within `distance` (data units) plus `share` times the span of the decoder's `value_range` of the voxel (0 if the
    /// decoder knows no range). Texture units that decode blocks are held to this.
    Levels {
        /// Data units.
        distance: f32,
        /// Fraction of the span, `0.0..1.0`.
        share: f32,
    },
}

impl Agreement {
    /// Largest allowed distance of a shader's value from the CPU's `cpu`, in data units. `range` is the decoder's
    /// `value_range` of the voxel, if known.
    #[must_use]
    pub fn tolerance(self, cpu: f32, range: Option<ValueRange>) -> f64 {
        match self {
            Self::Exact => 0.0,
            Self::Ulp(n) => f64::from(n) * range.unwrap_or(ValueRange { min: cpu, max: cpu }).ulp(),
            Self::Levels { distance, share } => {
                f64::from(distance) + f64::from(share) * range.map_or(0.0, ValueRange::span)
            }
        }
    }

    /// Whether a shader may return `shader` if the CPU decoder returns `cpu`. `range` as above. NaN is never allowed.
    #[must_use]
    pub fn allows(self, cpu: f32, shader: f32, range: Option<ValueRange>) -> bool {
        let distance = (f64::from(cpu) - f64::from(shader)).abs();
        cpu == shader || distance <= self.tolerance(cpu, range)
    }
}

/// Decodes every voxel with the real generated shader. Crates that own a device implement it, so that core and codecs
/// can test shaders without depending on devices.
pub trait VoxelDump {
    /// All decoded samples of `frame` (x fastest, channels interleaved, data units). With `use_cell`, each voxel is
    /// read through `<id>_fetch_cell`, and every corner of the cell serves some voxel.
    ///
    /// # Errors
    /// A sentence that says why there is no result: no device, a refused shader, a lost device.
    fn dump(
        &self,
        codec: &str,
        decoder: &dyn Decoder,
        frame: FrameIndex,
        use_cell: bool,
    ) -> Result<Vec<f32>, String> {
        self.dump_at(codec, decoder, (frame, Level::FULL), use_cell)
    }

    /// The same at a level.
    ///
    /// # Errors
    /// As [`VoxelDump::dump`].
    fn dump_at(
        &self,
        codec: &str,
        decoder: &dyn Decoder,
        key: (FrameIndex, Level),
        use_cell: bool,
    ) -> Result<Vec<f32>, String>;

    /// All decoded samples of a frame at a level, in the same order, decoded as at the site *deferred*: by the codec's
    /// own passes if it has any, and stored in the texel format of [`Decoder::decoded_form`].
    ///
    /// # Errors
    /// As [`VoxelDump::dump`].
    fn dump_frame(
        &self,
        codec: &str,
        decoder: &dyn Decoder,
        key: (FrameIndex, Level),
    ) -> Result<Vec<f32>, String>;
}

/// Format of one texel.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TexelFormat {
    /// 8 bits over 0..1.
    Unorm8,
    /// 16 bits over 0..1.
    Unorm16,
    /// IEEE half.
    Float16,
    /// IEEE single.
    Float32,
}

impl TexelFormat {
    /// Bytes per channel.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::Unorm8 => 1,
            Self::Unorm16 | Self::Float16 => 2,
            Self::Float32 => 4,
        }
    }
}

/// How texels hold decoded values: `value = offset + scale · texel`. A unorm texel reads as 0..1.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DecodedForm {
    /// Texel format.
    pub format: TexelFormat,
    /// Data units per texel unit.
    pub scale: f32,
    /// Value of texel 0.
    pub offset: f32,
}

impl DecodedForm {
    /// The value itself, in single precision.
    pub const FLOAT32: Self = Self { format: TexelFormat::Float32, scale: 1.0, offset: 0.0 };

    /// The smallest form that holds every sample of this type.
    #[must_use]
    pub const fn of(sample: SampleType) -> Self {
        let (format, scale, offset) = match sample {
            SampleType::U8 => (TexelFormat::Unorm8, 255.0, 0.0),
            SampleType::I8 => (TexelFormat::Unorm8, 255.0, -128.0),
            SampleType::U16 => (TexelFormat::Unorm16, 65535.0, 0.0),
            SampleType::I16 => (TexelFormat::Unorm16, 65535.0, -32768.0),
            SampleType::F32 => return Self::FLOAT32,
        };
        Self { format, scale, offset }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_of_one_bit_is_seen() {
        let one_up = 1.0_f32.next_up();
        assert!(Agreement::Exact.allows(0.0, -0.0, None));
        assert!(!Agreement::Exact.allows(1.0, one_up, None));
        assert!(Agreement::Ulp(1).allows(1.0, one_up, None));
        assert!(!Agreement::Ulp(1).allows(1.0, one_up.next_up(), None));
        assert!(Agreement::Ulp(1).allows(1.0, one_up.next_up(), Some(ValueRange { min: 0.0, max: 2.0 })));
        assert!(!Agreement::Ulp(4).allows(1.0, f32::NAN, None));
    }
}
