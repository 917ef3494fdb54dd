//! How a shader decodes one voxel: a snippet of WGSL, constants, and buffers of words.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::{Block, DecodeError, Decoder};
use crate::volume::{Extent, FrameIndex, Level, SampleType, ValueRange};

/// The decode side of a codec in WGSL.
pub trait ShaderDecode: Send + Sync {
    /// The snippet and its constants.
    fn module(&self) -> WgslModule<'_>;

    /// How closely the shader follows the CPU decoder.
    fn agreement(&self) -> Agreement;

    /// The codec's own buffers of one frame, in the order in which they are bound. Those of what a predicted frame is decoded
    /// from are bound behind them ([`super::References::resources`]).
    ///
    /// # Errors
    /// When the stream lacks one.
    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError>;
}

/// Text of a codec: a snippet, or a pass, whose contract is that of [`super::FramePass`].
///
/// A snippet declares `<id>_fetch(p: vec3<i32>) -> vec4<f32>` (p in bounds; a scalar in `.x`), optionally
/// `<id>_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8>` (the corners of the cell from `p` to
/// `q`, both in bounds, `q` = `p` or `p + 1` per axis; corner `i` takes x from bit 0, y from bit 1, z from
/// bit 2 of `i`), and only names that begin with `<id>_`. It has no `@group`.
#[derive(Clone, Debug)]
pub struct WgslModule<'a> {
    /// Path of the snippet as its author knows it; errors name it.
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

/// A buffer of 32-bit words, read in the snippet through `<id>_<name>(i: u32) -> u32`. The generator may split
/// it over several bindings; the snippet cannot tell.
#[derive(Clone, Debug)]
pub struct Resource<'a> {
    /// Name without the codec's prefix.
    pub name: &'static str,
    /// The words; an empty buffer is bound as one zero word.
    pub words: Cow<'a, [u32]>,
}

/// Agreement of shader, or texture unit, and CPU decoder.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Agreement {
    /// Bit for bit (zeros of either sign are equal).
    Exact,
    /// Within this many units in the last place of the largest magnitude in the decoder's `value_range` of the
    /// voxel (of the value itself where the decoder knows no range): a sum that cancels cannot promise more.
    Ulp(u32),
    /// Within `distance`, in data units, and `share` of the span of the decoder's `value_range` of the voxel (of nothing
    /// where the decoder knows no range): what texture units are held to that decode blocks themselves.
    Levels {
        /// Data units.
        distance: f32,
        /// Of the span, `0.0..1.0`.
        share: f32,
    },
}

impl Agreement {
    /// How far from the CPU decoder's `cpu` a shader may be, in data units; `range` is the decoder's `value_range` of the
    /// voxel, if it knows one.
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

    /// Whether a shader may yield `shader` where the CPU decoder yields `cpu`; `range` as above. What is no number is never
    /// allowed.
    #[must_use]
    pub fn allows(self, cpu: f32, shader: f32, range: Option<ValueRange>) -> bool {
        let distance = (f64::from(cpu) - f64::from(shader)).abs();
        cpu == shader || distance <= self.tolerance(cpu, range)
    }
}

/// Runs every voxel through the real generated shader. Whoever owns a device implements it, so that core and
/// codecs can be held to their shaders without knowing of devices.
pub trait VoxelDump {
    /// All decoded samples of `frame` (x fastest, channels interleaved, data units). With `use_cell` each voxel
    /// comes out of `<id>_fetch_cell`, every corner of the cell being used for some voxel.
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

    /// All decoded samples of a frame at a level, in the same order, as the site *deferred* decodes them: by the codec's
    /// own passes if it brings any, and through the texel of [`Decoder::decoded_form`].
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

/// How decoded values sit in a texel: `value = offset + scale · texel`, where a unorm texel reads as 0..1.
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

    /// What holds every sample of this type, in the fewest bytes.
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
