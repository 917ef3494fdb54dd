//! One experiment in several runs: cells dealt out, results joined.

pub mod merge;
pub mod shard;
