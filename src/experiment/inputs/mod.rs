//! What a run reads: volumes, and scenes held to them.

pub mod blank;
pub mod preview;
pub mod scenes;
pub mod volumes;
