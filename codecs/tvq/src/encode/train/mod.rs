//! Codebooks from blocks: transforms and classes of blocks, a single codebook, all codebooks of a table.

pub mod book;
pub mod classify;
pub mod curves;
pub mod shares;
pub mod trainer;
pub mod transform;
