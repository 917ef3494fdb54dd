//! How a training set is drawn.

use std::ops::Range;

use cvr_core::codec::{Block, EncodeError, Progress};
use cvr_core::volume::BrickSource;

use super::{stratified_training_vectors, training_vectors};
use crate::Vectors;

/// How training blocks are drawn, if there are more blocks than are trained on.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Draw {
    /// Each as likely as any other.
    Uniform,
    /// Half of them evenly over strata of the blocks' variance. Each has the weight of the blocks that it represents.
    Stratified,
}

impl Draw {
    /// All names, as settings have them.
    pub const NAMES: &'static [&'static str] = &["uniform", "stratified"];

    /// The way with that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "uniform" => Some(Self::Uniform),
            "stratified" => Some(Self::Stratified),
            _ => None,
        }
    }

    /// At most `count` blocks of the frames `frames`, as vectors.
    ///
    /// # Errors
    /// Those of reading, and when `run` was cancelled.
    pub fn vectors(
        self,
        source: &dyn BrickSource,
        block: Block,
        frames: Range<u32>,
        count: u64,
        seed: u64,
        run: &Progress<'_>,
    ) -> Result<Vectors, EncodeError> {
        match self {
            Self::Uniform => training_vectors(source, block, frames, count, seed, run),
            Self::Stratified => stratified_training_vectors(source, block, frames, count, seed, run),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_a_way_to_draw() {
        let ways: Vec<Draw> = Draw::NAMES.iter().filter_map(|name| Draw::named(name)).collect();
        assert_eq!(ways, [Draw::Uniform, Draw::Stratified]);
        assert_eq!(Draw::named("random"), None);
    }
}
