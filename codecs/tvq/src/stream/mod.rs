//! What a stream holds: parameters and sizes, tables, and where blocks lie. It names no other room.

pub mod geometry;
pub mod table;

/// Tensor and shader resource: how to read the blocks of each sub-volume.
pub const TABLES: &str = "tables";
/// Tensor and shader resource: the codewords.
pub const CODEBOOK: &str = "codebook";
/// Tensor and shader resource: means and codes.
pub const INDEX: &str = "index";
/// Tensor and shader resource: where the means and codes of each group begin.
pub const HEADS: &str = "heads";
