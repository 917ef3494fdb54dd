//! The encoding side: bricks in, tensors out.

use std::fmt::Debug;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize};

use super::EncodeError;
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

/// What an encoder promises of its stream; stored in the container.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EncodeReport {
    /// No decoded sample (integers: after rounding) differs from the source by more than this, in data units.
    pub error_bound: Option<f64>,
    /// Cases that the user should know of, one sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// The user asked to stop.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Cancelled;

/// Progress of a long run, and the way to stop it.
pub struct Progress<'a> {
    advance: Box<dyn Fn(u64) + Sync + Send + 'a>,
    cancelled: Option<&'a AtomicBool>,
}

impl<'a> Progress<'a> {
    /// Reports to `advance` (voxels done since the last call); stops when `cancelled` becomes true.
    pub fn new(advance: impl Fn(u64) + Sync + Send + 'a, cancelled: Option<&'a AtomicBool>) -> Self {
        Self { advance: Box::new(advance), cancelled }
    }

    /// Reports to nobody and never stops.
    #[must_use]
    pub fn silent() -> Self {
        Self::new(|_| {}, None)
    }

    /// `voxels` more are done.
    ///
    /// # Errors
    /// When the user asked to stop.
    pub fn advance(&self, voxels: u64) -> Result<(), Cancelled> {
        (self.advance)(voxels);
        match self.cancelled {
            Some(flag) if flag.load(Ordering::Relaxed) => Err(Cancelled),
            _ => Ok(()),
        }
    }
}

impl Debug for Progress<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Progress").field("cancelled", &self.cancelled).finish_non_exhaustive()
    }
}
