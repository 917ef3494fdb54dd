//! Tests of `s3dc` through its public interface.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

mod cells;
mod channels;
mod conformance;
mod real_volumes;
