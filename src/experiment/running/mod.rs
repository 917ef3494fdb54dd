//! What runs cells: volume by volume, codec by codec, cell by cell, frame by frame.

pub mod cell_run;
pub mod encoded;
pub mod frame_run;
pub mod interrupt;
pub mod latest;
pub mod outcome;
pub mod run;
pub mod runner;
pub mod shared;
pub mod single;
pub mod stage;

mod ledger;
mod volume_run;
