//! Experiments: cells run one by one, and the files of their results.

pub mod files;
pub mod identity;
pub mod inputs;
pub mod measured;
pub mod records;
pub mod running;
pub mod shards;
