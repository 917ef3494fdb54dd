//! Progress of a long run, and the way to stop it.

use std::fmt::{self, Debug};
use std::sync::atomic::{AtomicBool, Ordering};

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
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Progress").field("cancelled", &self.cancelled).finish_non_exhaustive()
    }
}
