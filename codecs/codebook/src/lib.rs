//! Codebooks: the part that all vector quantisers share.
//!
//! [`Vectors`] with weights go in, a [`Codebook`] of codewords in 8 or 16 bits comes out of [`train`], and a
//! [`Search`] finds the nearest codeword of any further vector. Every file holds one subject: drawing a training set
//! ([`sample`]), a first codebook ([`init`]), its refinement ([`lbg`]), how codewords are stored ([`Quantiser`]). Blocks
//! of a volume become vectors in [`blocks`], and indices become words in [`pack`].
//!
//! Results depend on the vectors and the settings alone: never on the number of threads, and not on the processor
//! either, since products in single precision only propose codewords and sums in double precision, taken in a fixed
//! order, decide.

pub mod blocks;
mod carry;
mod cells;
mod codebook;
mod distance;
pub mod init;
pub mod lbg;
pub mod pack;
mod quantise;
pub mod sample;
pub mod scale;
mod scores;
mod search;
pub mod settings;
mod train;
mod vectors;
mod wide;

pub use cells::Cells;
pub use codebook::{Codebook, index_bits};
pub use init::Initial;
pub use lbg::Trained;
pub use quantise::Quantiser;
pub use scale::Scale;
pub use search::{Nearest, Search};
pub use train::{Training, train, train_over};
pub use vectors::Vectors;
