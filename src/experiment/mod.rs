//! Experiments: what one cell yields, and the files in which results last.

pub mod provenance;
pub mod record;
pub mod results;
