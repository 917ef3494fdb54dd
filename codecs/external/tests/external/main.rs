//! Tests of `external` as an application sees it.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

mod commands;
mod conformance;
