//! The number type of a stored sample.

use serde::{Deserialize, Serialize};

/// Number type of the samples of a volume.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum SampleType {
    /// Unsigned, 8 bits.
    U8,
    /// Signed, 8 bits.
    I8,
    /// Unsigned, 16 bits.
    U16,
    /// Signed, 16 bits.
    I16,
    /// IEEE single precision.
    F32,
}

impl SampleType {
    /// All types, in the order in which help texts list them.
    pub const ALL: [Self; 5] = [Self::U8, Self::I8, Self::U16, Self::I16, Self::F32];

    /// Name used in TOML and in containers: `u8`, `i8`, `u16`, `i16`, `f32`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::F32 => "f32",
        }
    }

    /// The type with this [`SampleType::name`].
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|t| t.name() == name)
    }

    /// Bytes per sample.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::F32 => 4,
        }
    }

    /// Bits per sample.
    #[must_use]
    pub const fn bits(self) -> u32 {
        self.bytes() as u32 * 8
    }

    /// Lowest and highest value of an integer type; `None` for floats.
    #[must_use]
    pub const fn integer_range(self) -> Option<(i32, i32)> {
        match self {
            Self::U8 => Some((0, u8::MAX as i32)),
            Self::I8 => Some((i8::MIN as i32, i8::MAX as i32)),
            Self::U16 => Some((0, u16::MAX as i32)),
            Self::I16 => Some((i16::MIN as i32, i16::MAX as i32)),
            Self::F32 => None,
        }
    }

    /// Whether samples are integers.
    #[must_use]
    pub const fn is_integer(self) -> bool {
        self.integer_range().is_some()
    }
}

impl std::fmt::Display for SampleType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
