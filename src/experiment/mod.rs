//! Experiments: cells run one by one, and the files in which their results last.

pub mod cell_run;
pub mod deferred;
pub mod encoded;
pub mod machine;
pub mod provenance;
pub mod record;
pub mod results;
pub mod runner;
pub mod stage;
pub mod target;
pub mod volumes;
