//! Tests of `rvq` as an application sees it.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

mod cells;
mod coding;
mod conformance;
mod levels;
mod real_volumes;
mod streams;
mod variable;
