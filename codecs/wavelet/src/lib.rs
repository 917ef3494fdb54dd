//! Wavelets of whole volumes.
pub mod blocks;
pub mod coders;
pub mod stream;
