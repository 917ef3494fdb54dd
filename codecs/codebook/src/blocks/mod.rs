//! Blocks of a volume as vectors.

mod cut;
mod row;
mod training;

pub use cut::{cuts, inside};
pub use row::BlockRow;
pub use training::{training_vectors, value_range};
