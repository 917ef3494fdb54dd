//! The number type of a sample in a file. It may be wider than the type in memory.

use super::SampleType;

/// Number type of the samples in a file. Types wider than any [`SampleType`] are kept as [`SampleType::F32`]. Samples
/// that single precision cannot hold are rounded to nearest and counted in [`super::Replaced::rounded`].
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub enum StoredType {
    /// Unsigned, 8 bits.
    U8,
    /// Signed, 8 bits.
    I8,
    /// Unsigned, 16 bits.
    U16,
    /// Signed, 16 bits.
    I16,
    /// Unsigned, 32 bits.
    U32,
    /// Signed, 32 bits.
    I32,
    /// Unsigned, 64 bits.
    U64,
    /// Signed, 64 bits.
    I64,
    /// IEEE single precision.
    F32,
    /// IEEE double precision.
    F64,
}

impl StoredType {
    /// All types, in the order in which help texts list them.
    pub const ALL: [Self; 10] = [
        Self::U8,
        Self::I8,
        Self::U16,
        Self::I16,
        Self::U32,
        Self::I32,
        Self::U64,
        Self::I64,
        Self::F32,
        Self::F64,
    ];

    /// Name used in TOML and on the command line: `u8`, `i8`, …, `f64`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::U64 => "u64",
            Self::I64 => "i64",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    /// The type with this [`StoredType::name`].
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|t| t.name() == name)
    }

    /// Bytes per sample in the file.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// The type in which samples are kept.
    #[must_use]
    pub const fn kept(self) -> SampleType {
        match self {
            Self::U8 => SampleType::U8,
            Self::I8 => SampleType::I8,
            Self::U16 => SampleType::U16,
            Self::I16 => SampleType::I16,
            _ => SampleType::F32,
        }
    }

    /// Whether every sample is kept unchanged.
    #[must_use]
    pub const fn is_kept_exactly(self) -> bool {
        matches!(self, Self::U8 | Self::I8 | Self::U16 | Self::I16 | Self::F32)
    }
}

impl From<SampleType> for StoredType {
    fn from(sample: SampleType) -> Self {
        match sample {
            SampleType::U8 => Self::U8,
            SampleType::I8 => Self::I8,
            SampleType::U16 => Self::U16,
            SampleType::I16 => Self::I16,
            SampleType::F32 => Self::F32,
        }
    }
}

impl std::fmt::Display for StoredType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back_and_kept_types_keep_their_width() {
        for stored in StoredType::ALL {
            assert_eq!(StoredType::from_name(stored.name()), Some(stored));
            let exact = StoredType::from(stored.kept()) == stored;
            assert_eq!(stored.is_kept_exactly(), exact, "{stored}");
            assert!(!exact || stored.kept().bytes() == stored.bytes(), "{stored}");
        }
        assert_eq!(StoredType::from_name("f16"), None);
    }
}
