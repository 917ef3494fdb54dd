//! Codebooks: the part that all vector quantisers share.
//!
//! [`train`] turns weighted [`Vectors`] into a [`Codebook`] of codewords in 8 or 16 bits. A [`Search`] finds the
//! nearest codeword of any further vector. Every file holds one subject: drawing a training set ([`sample`]), a first
//! codebook ([`init`]), its refinement ([`lbg`]), storage of codewords ([`Quantiser`]). [`blocks`] turns blocks of a
//! volume into vectors; [`pack`] turns indices into words.
//!
//! Results depend only on vectors and settings, not on the number of threads or the processor. Products in single
//! precision only propose codewords. Sums in double precision, in a fixed order, decide.

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
pub use search::{Nearest, Search};
pub use train::{Training, train, train_over};
pub use vectors::Vectors;
