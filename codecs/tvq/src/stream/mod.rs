//! Content of a stream: parameters and sizes, tables, scales of entries, and packed numbers. It depends on no other
//! module of the codec.

pub mod bits;
pub mod geometry;
pub mod table;

/// Tensor and shader resource: how to read the blocks of each sub-volume.
pub const TABLES: &str = "tables";
/// Tensor and shader resource: the codewords.
pub const CODEBOOK: &str = "codebook";
/// Tensor and shader resource: means and codes.
pub const INDEX: &str = "index";
/// Tensor and shader resource: start of the means and codes of each brick.
pub const HEADS: &str = "heads";

pub use cvr_codebook::scale;
