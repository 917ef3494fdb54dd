//! Entropy coders: quantised coefficients as bytes, and back.

pub mod arithmetic;
pub mod bands;
pub mod bits;
pub mod contexts;
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
