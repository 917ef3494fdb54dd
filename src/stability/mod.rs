//! The stability atlas: every codec on volumes and in scenes that are made to break codecs, and the verdicts.
//! Volumes and rules are those of `cvr_core::stability`; `docs/user/stability.md` documents the rules.

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
