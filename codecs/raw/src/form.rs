//! How a 32-bit word holds samples, and the parameters of the stream.

use cvr_core::volume::{SampleType, ValueRange, VolumeLayout};
use serde::{Deserialize, Serialize};

/// The setting `bits`.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Bits {
    /// The sample's own type.
    #[serde(rename = "native")]
    Native,
    /// 8 bits over the volume's value range.
    #[serde(rename = "8")]
    Eight,
    /// IEEE half precision.
    #[serde(rename = "half")]
    Half,
}

impl Bits {
    /// The value with this name in a configuration: `native`, `8` or `half`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "native" => Some(Self::Native),
            "8" => Some(Self::Eight),
            "half" => Some(Self::Half),
            _ => None,
        }
    }
}

/// The meaning of a code. The discriminant is the constant `raw_kind` of decode.wgsl.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Kind {
    /// An unsigned integer.
    Unsigned = 0,
    /// An integer in two's complement.
    Signed = 1,
    /// The bit pattern of an IEEE single.
    Single = 2,
    /// The bit pattern of an IEEE half.
    Half = 3,
    /// An integer in steps from the lowest value on.
    Scaled = 4,
}

/// Everything that converts a word to values: the constants of decode.wgsl.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Form {
    /// Bits per code: 8, 16 or 32.
    pub bits: u32,
    /// Binary logarithm of the codes per word: 2, 1 or 0.
    pub lanes_log2: u32,
    /// Meaning of a code.
    pub kind: Kind,
    /// [`Kind::Scaled`]: value of code 0, in data units.
    pub offset: f32,
    /// [`Kind::Scaled`]: data units per code.
    pub step: f32,
    /// [`Kind::Scaled`]: no value exceeds this.
    pub high: f32,
}

/// The decode parameters in the container.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// The setting.
    pub bits: Bits,
    /// Lowest and highest decoded value over all frames and channels.
    pub range: ValueRange,
}

impl Form {
    /// The form of samples of type `sample` under `bits`. `range` is the range of the volume.
    #[must_use]
    pub fn new(bits: Bits, sample: SampleType, range: ValueRange) -> Self {
        let (width, kind) = match (bits, sample.integer_range()) {
            (Bits::Half, _) => (16, Kind::Half),
            (Bits::Eight, _) => (8, Kind::Scaled),
            (Bits::Native, None) => (32, Kind::Single),
            (Bits::Native, Some((low, _))) if low < 0 => (sample.bits(), Kind::Signed),
            (Bits::Native, Some(_)) => (sample.bits(), Kind::Unsigned),
        };
        let scaled = kind == Kind::Scaled;
        Self {
            bits: width,
            lanes_log2: (32 / width).ilog2(),
            kind,
            offset: if scaled { range.min } else { 0.0 },
            step: if scaled { (range.span() / 255.0) as f32 } else { 1.0 },
            high: if scaled { range.max } else { 0.0 },
        }
    }

    /// Codes in one word.
    #[must_use]
    pub const fn lanes(&self) -> usize {
        1 << self.lanes_log2
    }

    /// Words of one frame. The last word is padded with zero codes.
    #[must_use]
    pub const fn words_per_frame(&self, layout: &VolumeLayout) -> u64 {
        layout.samples_per_frame().div_ceil(1 << self.lanes_log2)
    }
}
