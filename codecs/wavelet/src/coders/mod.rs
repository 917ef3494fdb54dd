//! Entropy coders: quantised coefficients as bytes, and back.

pub mod arithmetic;
pub mod bands;
pub mod bits;
pub mod contexts;
pub mod corrections;
pub mod counts;
pub mod deflate;
pub mod family;
pub mod fault;
pub mod order;
pub mod range;
pub mod region;
pub mod runs;
pub mod symbols;
pub mod values;
pub mod words;
pub mod zerotree;

#[cfg(test)]
mod tests;

use cvr_core::codec::DecodeError;
use serde::{Deserialize, Serialize};

use crate::stream::pyramid::Pyramid;

/// Writes quantised coefficients as chunks of bytes, and reads them. Chunks are independent as far as the coder can
/// make them so, and are then coded in parallel. The number of threads never changes a byte.
pub trait Coder: Sync {
    /// Number of chunks of a volume.
    fn chunks(&self, pyramid: &Pyramid) -> usize;

    /// The chunks of all bands. `coefficients` are in the order of [`Pyramid`].
    fn encode(&self, pyramid: &Pyramid, coefficients: &[i32]) -> Vec<Vec<u8>>;

    /// Reads LLL and the `levels` coarsest levels into `out`, which has [`Pyramid::coefficients`] of them, all 0.
    /// `chunks` are all chunks of the volume. Those of finer levels are not read.
    ///
    /// # Errors
    /// [`DecodeError::Corrupt`] if a chunk is no output of [`Coder::encode`]. It may also decode to wrong coefficients,
    /// but neither panics nor allocates more than a small multiple of `out` and the chunks.
    fn decode(
        &self,
        pyramid: &Pyramid,
        levels: usize,
        chunks: &[&[u8]],
        out: &mut [i32],
    ) -> Result<(), DecodeError>;
}

/// The coders by name, as streams hold them.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coding {
    /// Contexts and a binary range coder.
    Contexts,
    /// Runs of zeros line by line.
    Runs,
    /// Runs of zeros through an octree.
    RunsOctree,
    /// Runs of zeros line by line, through deflate.
    Deflate,
    /// Runs of zeros through an octree, and through deflate.
    DeflateOctree,
    /// Adaptive arithmetic coding with a zero mode.
    Arithmetic,
    /// Zerotrees.
    Zerotree,
}

impl Coding {
    /// Names of the coders, without orders.
    pub const NAMES: &'static [&'static str] = &["contexts", "runs", "deflate", "arithmetic", "zerotree"];

    /// The coding of a coder and an order. Only runs have an order.
    #[must_use]
    pub fn from_names(coder: &str, order: &str) -> Option<Self> {
        Some(match (coder, order) {
            ("contexts", _) => Self::Contexts,
            ("runs", "octree") => Self::RunsOctree,
            ("runs", _) => Self::Runs,
            ("deflate", "octree") => Self::DeflateOctree,
            ("deflate", _) => Self::Deflate,
            ("arithmetic", _) => Self::Arithmetic,
            ("zerotree", _) => Self::Zerotree,
            _ => return None,
        })
    }

    /// The coder.
    #[must_use]
    pub fn coder(self) -> &'static dyn Coder {
        match self {
            Self::Contexts => &contexts::Contexts,
            Self::Runs => &runs::Runs { order: order::Order::Lines },
            Self::RunsOctree => &runs::Runs { order: order::Order::Octree },
            Self::Deflate => &deflate::Deflate { order: order::Order::Lines },
            Self::DeflateOctree => &deflate::Deflate { order: order::Order::Octree },
            Self::Arithmetic => &arithmetic::Arithmetic,
            Self::Zerotree => &zerotree::Zerotree,
        }
    }
}
