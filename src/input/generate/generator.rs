//! The test signals by their names.

use serde::{Deserialize, Serialize};

/// A test signal.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Generator {
    /// Ellipsoids of constant density, in the outlines of a head.
    SheppLogan,
    /// The signal of Marschner and Lobb (1994), close to the Nyquist limit of 40³ voxels.
    MarschnerLobb,
    /// Octaves of value noise, seeded, from integer arithmetic alone.
    Turbulence,
    /// Smooth blobs in a vortex, seeded: the one that moves.
    AdvectedBlobs,
    /// A number of its own for every voxel, seeded: nothing that could be compressed.
    WhiteNoise,
}

impl Generator {
    /// All generators, in the order in which help texts list them.
    pub const ALL: [Self; 5] =
        [Self::SheppLogan, Self::MarschnerLobb, Self::Turbulence, Self::AdvectedBlobs, Self::WhiteNoise];

    /// Name used in TOML and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::SheppLogan => "shepp-logan",
            Self::MarschnerLobb => "marschner-lobb",
            Self::Turbulence => "turbulence",
            Self::AdvectedBlobs => "advected-blobs",
            Self::WhiteNoise => "white-noise",
        }
    }

    /// The generator with this [`Generator::name`].
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|g| g.name() == name)
    }
}

impl std::fmt::Display for Generator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
