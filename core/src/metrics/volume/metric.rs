//! What a metric of voxels is.

use super::slab::Slab;
use crate::codec::Block;
use crate::metrics::Figure;
use crate::volume::{BrickSource, FiniteVolume, VolumeLayout};

/// What is compared, before a decoded frame is seen.
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
    /// What is added up.
    type Sums: Default + Send;
    /// What the sums of all frames come to.
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
