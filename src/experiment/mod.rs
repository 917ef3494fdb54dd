//! Experiments: cells run one by one, and the files in which their results last.

pub mod blank;
pub mod cell_file;
pub mod cell_run;
pub mod checked;
pub mod encoded;
pub mod error_histogram;
pub mod files;
pub mod folder;
pub mod frame_figures;
pub mod frame_run;
pub mod identity;
pub mod interrupt;
pub mod key;
pub mod labels;
pub mod latest;
pub mod machine;
pub mod merge;
pub mod outcome;
pub mod pool;
pub mod preview;
pub mod provenance;
pub mod record;
pub mod results;
pub mod run;
pub mod runner;
pub mod scenes;
pub mod series;
pub mod shard;
pub mod shared;
pub mod single;
pub mod skipping;
pub mod stage;
pub mod surfaces;
pub mod volumes;

mod ledger;
mod volume_run;
