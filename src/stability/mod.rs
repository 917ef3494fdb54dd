//! The stability atlas: every codec through volumes and scenes that provoke, and verdicts on what it makes of them.
//! Volumes and rules are those of `cvr_core::stability`; the rules are told in `docs/stability.md`.

pub mod atlas;
pub mod breaking;
pub mod claim;
pub mod config;
pub mod drawing;
pub mod encoder;
pub mod measured;
pub mod plan;
pub mod report;
pub mod row;
pub mod runner;
pub mod scenes;
