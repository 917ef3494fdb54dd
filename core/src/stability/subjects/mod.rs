//! Volumes that are made to break codecs, each with a dial of difficulty. All are computed from integer hashes and arithmetic that is the
//! same everywhere (the sinusoid alone asks the machine for cosines, and rounds them to 16 bits).

mod edges;
mod field;
mod sequences;
mod shapes;
mod smooth;
#[cfg(test)]
mod tests;
mod values;

use crate::volume::{DenseVolume, FiniteVolume, FrameIndex};

/// A volume with a dial.
#[derive(Copy, Clone, Debug)]
pub struct Subject {
    /// Name in records and on command lines.
    pub name: &'static str,
    /// One line about the subject.
    pub doc: &'static str,
    /// Meaning of the dial, with its unit.
    pub dial: &'static str,
    /// Places of the dial, the easiest first.
    pub steps: &'static [f64],
    /// Whether samples are names of things, between which there is nothing: drawn without interpolation.
    pub labels: bool,
    /// Which frame is drawn: of a sequence one that has others before it.
    pub frame: FrameIndex,
    maker: fn(f64, u32) -> DenseVolume,
}

impl Subject {
    const fn field(
        name: &'static str,
        doc: &'static str,
        dial: &'static str,
        steps: &'static [f64],
        maker: fn(f64, u32) -> DenseVolume,
    ) -> Self {
        Self { name, doc, dial, steps, labels: false, frame: FrameIndex::FIRST, maker }
    }

    /// All subjects, in the order of tables.
    pub fn all() -> impl Iterator<Item = &'static Self> {
        [smooth::SUBJECTS, edges::SUBJECTS, values::SUBJECTS, shapes::SUBJECTS, sequences::SUBJECTS]
            .into_iter()
            .flatten()
    }

    /// The subject of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::all().find(|subject| subject.name == name)
    }

    /// The volume at a step of the dial, made finite as every input is. No axis is longer than `edge` voxels; frames of
    /// sequences are two thirds of it.
    ///
    /// # Panics
    /// When there is no such step, or `edge` is not among [`Subject::EDGES`].
    #[must_use]
    pub fn volume(&self, step: usize, edge: u32) -> FiniteVolume {
        assert!(Self::EDGES.contains(&edge), "an edge of {edge} voxels");
        FiniteVolume::new((self.maker)(self.steps[step], edge))
    }

    /// Edges that volumes may have, in voxels.
    pub const EDGES: std::ops::RangeInclusive<u32> = 12..=48;
}
