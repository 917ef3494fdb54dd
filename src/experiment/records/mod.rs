//! One record per cell: its columns, what it says in words, and where it comes from.

pub mod checked;
pub mod columns;
pub mod labels;
pub mod machine;
pub mod provenance;
pub mod record;
pub mod series;

mod pooled;
