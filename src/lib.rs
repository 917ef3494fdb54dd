//! `cvr`, a workbench for compressed volume rendering: configure experiments, add codecs, compare fairly.

pub mod experiment;
pub mod input;
pub mod report;
