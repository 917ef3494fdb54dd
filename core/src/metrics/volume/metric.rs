//! The trait of voxel metrics.

use super::slab::Slab;
use crate::codec::Block;
use crate::metrics::Figure;
use crate::volume::{BrickSource, FiniteVolume, VolumeLayout};

/// The part of a comparison that does not depend on a decoded frame.
#[derive(Copy, Clone, Debug)]
pub(super) struct Subject<'a> {
    /// The original.
    pub(super) reference: &'a FiniteVolume,
    /// The codec's block, where it has one.
    pub(super) block: Option<Block>,
}

impl Subject<'_> {
    pub(super) fn layout(&self) -> &VolumeLayout {
        self.reference.layout()
    }
}

/// Adds up over slabs, which are fixed pieces and come in their order, and yields figures of the whole.
pub(super) trait Metric: Sync + Sized {
    /// The figures, in the order in which [`Metric::values`] gives them.
    const FIGURES: &'static [Figure];
    /// The sums.
    type Sums: Default + Send;
    /// The results from the sums of all frames.
    type Outcome;

    /// Prepares what the original alone decides.
    fn new(subject: &Subject<'_>) -> Self;
    /// The sums of one slab.
    fn slab(&self, slab: &Slab<'_>) -> Self::Sums;
    /// Adds the sums of what comes next.
    fn add(&self, sums: &mut Self::Sums, next: Self::Sums);
    /// The end, of all frames.
    fn finish(&self, subject: &Subject<'_>, sums: Self::Sums) -> Self::Outcome;
    /// As many values as [`Metric::FIGURES`].
    fn values(outcome: &Self::Outcome) -> Vec<Option<f64>>;
}
