//! Tests of `wavelet` through its public interface.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

mod blocks;
mod conformance;
mod hostile;
mod real_volumes;
mod resolutions;
mod streams;
mod targets;
mod whole;
