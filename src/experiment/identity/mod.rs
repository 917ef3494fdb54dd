//! What makes a cell, a result and an experiment this one and no other.

pub mod cell;
pub mod experiment;
pub mod key;
pub mod owner;
