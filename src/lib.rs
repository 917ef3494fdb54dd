//! `cvr`, a workbench for compressed volume rendering: configure experiments, add codecs, compare fairly.

#[macro_use]
mod say;

pub mod cli;
pub mod commands;
pub mod compare;
pub mod estimate;
pub mod exit;
pub mod experiment;
pub mod input;
pub mod progress;
pub mod registry;
pub mod report;
pub mod site;
pub mod stability;
