//! Blocks of a volume as vectors.

mod cut;
mod draw;
mod strata;
mod training;

pub use cut::{cuts, inside};
pub use draw::Draw;
pub use strata::stratified_training_vectors;
pub use training::training_vectors;
