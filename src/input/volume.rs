//! A volume as it was read, with what reading did to it.

use cvr_core::volume::{BrickSource as _, DenseVolume, FiniteVolume, StoredType};

use super::layout::StoredLayout;
use super::samples::SampleSink;

/// A volume, and what its file had that the volume has not.
#[derive(Clone, Debug, PartialEq)]
pub struct InputVolume {
    /// The samples.
    pub volume: DenseVolume,
    /// Number type in the file.
    pub stored: StoredType,
    /// Samples that single precision cannot hold exactly and that were rounded to it: those of wider types, and
    /// those that the file wants scaled.
    pub rounded: u64,
}

impl InputVolume {
    /// # Errors
    /// A sentence, when the samples are not those of the layout.
    pub(super) fn new(layout: &StoredLayout, sink: SampleSink) -> Result<Self, String> {
        let (samples, rounded) = sink.finish();
        let volume = DenseVolume::new(layout.layout.clone(), samples)?;
        Ok(Self { volume, stored: layout.stored, rounded })
    }

    /// A volume that was not read from a wider type.
    #[must_use]
    pub fn exact(volume: DenseVolume) -> Self {
        let stored = volume.layout().sample.into();
        Self { volume, stored, rounded: 0 }
    }

    /// The volume that codecs see.
    #[must_use]
    pub fn finite(self) -> FiniteVolume {
        FiniteVolume::narrowed(self.volume, self.rounded)
    }
}
