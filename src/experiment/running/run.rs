//! A run: its inputs, and functions that its parts use.

use std::sync::atomic::{AtomicBool, Ordering};

use cvr_core::pipeline::{Cell, Experiment, FrameRange, Resolution};

use super::cell_run::empty_record;
use super::ledger::Ledger;
use super::outcome::RunError;
use crate::experiment::files::folder::OutFolder;
use crate::experiment::identity::key::Keys;
use crate::experiment::inputs::volumes::LoadedVolume;
use crate::experiment::records::record::Record;
use crate::registry::Names;
use crate::site::target::Target;

/// Everything that a run needs.
pub struct Run<'a> {
    /// The experiment.
    pub experiment: &'a Experiment,
    /// Its cells and refusals.
    pub resolution: &'a Resolution,
    /// Its volumes, loaded, in its order.
    pub volumes: &'a [LoadedVolume],
    /// Codecs by id.
    pub names: &'a Names,
    /// What draws.
    pub target: &'a Target,
    /// Opens the target again after it was lost.
    pub reopen: &'a dyn Fn() -> Result<Target, String>,
    /// Where results go.
    pub out: &'a OutFolder,
    /// Once true, the run ends after the running step.
    pub stop: &'a AtomicBool,
    /// Called before each cell with the number of finished cells, and the cell's name.
    pub report: &'a dyn Fn(usize, &str),
}

/// A cell and its number.
#[derive(Copy, Clone)]
pub(super) struct Numbered<'a> {
    pub(super) index: usize,
    pub(super) cell: &'a Cell,
}

impl<'a> Run<'a> {
    /// Records cells as failed for one reason.
    pub(super) fn fail(
        &self,
        cells: &[Numbered<'_>],
        volume: &LoadedVolume,
        target: &Target,
        problem: &str,
        ledger: &mut Ledger<'_>,
    ) -> Result<(), RunError> {
        for Numbered { index, cell } in cells {
            let record = self.empty_record(cell, volume, target);
            let key = self.keys().of(cell, volume, target);
            ledger.finish(*index, cell, record, key, Err(problem.to_owned()))?;
        }
        Ok(())
    }

    pub(super) fn cells_of(&self, volume: &LoadedVolume) -> impl Iterator<Item = Numbered<'a>> {
        let cells = self.resolution.cells.iter().enumerate();
        cells.filter(|(_, c)| c.volume == volume.name).map(|(index, cell)| Numbered { index, cell })
    }

    pub(super) const fn keys(&self) -> Keys<'a> {
        Keys { experiment: self.experiment, names: self.names }
    }

    /// A record with everything known of a cell before it runs.
    pub(super) fn empty_record(&self, cell: &Cell, volume: &LoadedVolume, target: &Target) -> Record {
        let codec = self.names.codecs().get(&cell.codec);
        let series = codec.map(|codec| codec.info().series(&cell.settings)).unwrap_or_default();
        empty_record(cell, series, self.frames(cell), &volume.volume, target)
    }

    /// The frames that the scene of a cell draws.
    pub(super) fn frames(&self, cell: &Cell) -> FrameRange {
        self.experiment.scene(&cell.scene).map(|scene| scene.frames).unwrap_or_default()
    }

    pub(super) fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}
