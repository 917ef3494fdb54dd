//! The encoding side: bricks in, tensors out.

use std::fmt::Debug;

use super::{EncodeError, EncodeReport, Progress};
use crate::container::StreamWriter;
use crate::volume::{BrickSource, VolumeLayout};

/// Encodes one volume.
pub trait Encoder: Send + Debug {
    /// Bytes that encoding a volume of this layout holds at its height beside the source and the stream, about. Asked before
    /// anything is encoded, and compared with what may be taken; slabs of a few slices need not be counted.
    fn scratch_bytes(&self, _layout: &VolumeLayout) -> u64 {
        0
    }

    /// Reads `source` brick by brick and appends tensors and decode parameters to `out`. The source holds
    /// only finite, non-subnormal values (see [`crate::volume::FiniteVolume`]).
    ///
    /// The bytes written depend on source and settings alone, never on the number of threads.
    ///
    /// # Errors
    /// When the codec cannot encode such a volume, reading or writing fails, or `run` was cancelled.
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError>;
}
