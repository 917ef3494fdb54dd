//! How the values of a codeword are stored.

use serde::{Deserialize, Serialize};

/// How the values of a codeword are stored.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Entries {
    /// 8 bits each, four in a word.
    #[serde(rename = "8")]
    Bits8,
    /// 16 bits each, two in a word.
    #[serde(rename = "16")]
    Bits16,
    /// The three colours of a voxel in 11, 11 and 10 bits, in one word.
    #[serde(rename = "11-11-10")]
    Colours,
}

impl Entries {
    /// The form of that name; none for `auto`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "8" => Some(Self::Bits8),
            "16" => Some(Self::Bits16),
            _ => None,
        }
    }

    /// The form where none is asked for.
    #[must_use]
    pub const fn natural(channels: u32) -> Self {
        if channels == 3 { Self::Colours } else { Self::Bits8 }
    }

    /// Bits of a code that the scale of a stage counts in: those of colours are the upper ones of 16.
    #[must_use]
    pub const fn code_bits(self) -> u32 {
        match self {
            Self::Bits8 => 8,
            Self::Bits16 | Self::Colours => 16,
        }
    }

    /// Binary logarithm of the entries in one word. An entry is a value, or the three of a voxel.
    #[must_use]
    pub const fn lanes_log2(self) -> u32 {
        match self {
            Self::Bits8 => 2,
            Self::Bits16 => 1,
            Self::Colours => 0,
        }
    }

    /// Entries of one voxel.
    #[must_use]
    pub const fn per_voxel(self, channels: u32) -> u32 {
        match self {
            Self::Bits8 | Self::Bits16 => channels,
            Self::Colours => 1,
        }
    }

    /// Lower bits of a code that are not stored, for channel `c`.
    #[must_use]
    pub const fn dropped(self, c: usize) -> u32 {
        match self {
            Self::Bits8 | Self::Bits16 => 0,
            Self::Colours => {
                if c == 2 {
                    6
                } else {
                    5
                }
            }
        }
    }
}
