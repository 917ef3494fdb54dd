//! Tests of `tvq` through its public interface.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

mod cells;
mod coding;
mod conformance;
mod neighbours;
mod real_volumes;
mod streams;
