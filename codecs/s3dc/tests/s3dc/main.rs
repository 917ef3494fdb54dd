//! Tests of `s3dc` as an application sees it.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

mod cells;
mod channels;
mod conformance;
mod real_volumes;
