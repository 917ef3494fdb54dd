//! Experiments: cells run one by one, and the files in which their results last.

pub mod cell_file;
pub mod cell_run;
pub mod deferred;
pub mod encoded;
pub mod folder;
pub mod interrupt;
pub mod key;
pub mod machine;
pub mod merge;
pub mod provenance;
pub mod record;
pub mod results;
pub mod ring;
pub mod runner;
pub mod shard;
pub mod skipping;
pub mod stage;
pub mod target;
pub mod volumes;

mod ledger;
mod volume_run;
