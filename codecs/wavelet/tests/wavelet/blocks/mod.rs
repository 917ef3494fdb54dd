//! Blocks that decode on their own.

mod codec;
mod coding;
mod conformance;
mod hostile;
mod real_volumes;
mod targets;
