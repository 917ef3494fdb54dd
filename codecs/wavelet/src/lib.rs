//! Wavelets of whole volumes.
pub mod coders;
pub mod stream;
pub mod transform;
