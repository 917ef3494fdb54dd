//! The first codebook. [`crate::lbg`] refines it. One file for each method.

pub mod pca;
pub mod pnn;
pub mod random;
pub mod scalar;

use cvr_core::codec::{Cancelled, Progress};
use serde::{Deserialize, Serialize};

use crate::Vectors;

/// How the first codebook is made.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Initial {
    /// Cells cut across their principal axis: [`pca`].
    #[default]
    Pca,
    /// Clusters united pair by pair: [`pnn`].
    Pnn,
    /// Points of a grid of scalar quantisers: [`scalar`].
    Scalar,
    /// Vectors drawn by chance: [`random`].
    Random,
}

/// What refinement begins with.
pub(crate) struct First {
    /// One after the other.
    pub codewords: Vec<f64>,
    /// A codeword near each vector, if the method yields it.
    pub cells: Option<Vec<u32>>,
}

impl Initial {
    /// All names, as settings and records have them.
    pub const NAMES: &'static [&'static str] = &["pca", "pnn", "scalar", "random"];

    /// The method with that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        [Self::Pca, Self::Pnn, Self::Scalar, Self::Random].into_iter().find(|i| i.name() == name)
    }

    /// As settings and records have it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pca => "pca",
            Self::Pnn => "pnn",
            Self::Scalar => "scalar",
            Self::Random => "random",
        }
    }

    /// At most `size` vectors, concatenated, before they are quantised. `seed` controls random choices.
    ///
    /// # Errors
    /// When `run` was cancelled.
    ///
    /// # Panics
    /// When there are no vectors, or `size` is zero.
    pub fn codewords(
        self,
        vectors: &Vectors,
        size: usize,
        seed: u64,
        run: &Progress<'_>,
    ) -> Result<Vec<f64>, Cancelled> {
        Ok(self.begin(vectors, size, seed, run)?.codewords)
    }

    pub(crate) fn begin(
        self,
        vectors: &Vectors,
        size: usize,
        seed: u64,
        run: &Progress<'_>,
    ) -> Result<First, Cancelled> {
        let codewords = match self {
            Self::Pca => {
                let split = pca::split(vectors, size, run)?;
                return Ok(First { codewords: split.means, cells: Some(split.cells) });
            }
            Self::Pnn => pnn::unite(vectors, size, seed, run)?,
            Self::Scalar => scalar::grid(vectors, size, run)?,
            Self::Random => random::draw(vectors, size, seed),
        };
        Ok(First { codewords, cells: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::IntoDeserializer as _;

    #[test]
    fn names_are_those_of_the_records() {
        for name in Initial::NAMES {
            let initial = Initial::named(name).unwrap();
            assert_eq!(initial.name(), *name);
            let text: serde::de::value::StrDeserializer<'_, serde::de::value::Error> =
                name.into_deserializer();
            assert_eq!(Initial::deserialize(text), Ok(initial));
        }
        assert_eq!(Initial::named("k-means++"), None);
    }
}
