//! Tests of the block mode through its public interface.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

mod codec;
mod coding;
mod conformance;
mod hostile;
mod real_volumes;
mod targets;
