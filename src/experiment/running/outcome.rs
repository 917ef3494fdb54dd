//! What a run yields.

use crate::experiment::records::provenance::{Provenance, RefusedCell};
use crate::experiment::records::record::{Record, Status};

/// Results of a run.
#[derive(Debug)]
pub struct Outcome {
    /// One record per finished cell, in the order of the cells.
    pub records: Vec<Record>,
    /// The cells that could not exist.
    pub refused: Vec<RefusedCell>,
    /// Provenance with the reference pictures.
    pub provenance: Provenance,
    /// Records that an earlier run had finished.
    pub taken_over: usize,
    /// Number of encodings, by a codec or for the baseline.
    pub encodings: usize,
    /// Cells that were not run since the run was stopped.
    pub missing: usize,
}

impl Outcome {
    /// Cells that did not run, or broke a promise.
    #[must_use]
    pub fn failed(&self) -> usize {
        self.records.iter().filter(|r| r.status == Status::Failed).count()
    }
}

/// Why a run cannot go on. A failed cell is not such a reason.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct RunError(pub String);
