//! Running an experiment: volume by volume, codec by codec, cell by cell. Every cell's result is on disk before
//! the next one begins, so that whatever ends the process costs no more than the cell that runs.

use std::sync::atomic::{AtomicBool, Ordering};

use cvr_core::pipeline::{Cell, Experiment, FrameRange, Refusal, Resolution};

use super::cell_run::empty_record;
use super::folder::OutFolder;
use super::key::Keys;
use super::ledger::Ledger;
use super::provenance::{Provenance, RefusedCell};
use super::record::{Record, Status};
use super::volume_run::VolumeRun;
use super::volumes::LoadedVolume;
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
    /// Opens what draws anew, after it was lost.
    pub reopen: &'a dyn Fn() -> Result<Target, String>,
    /// Where results go.
    pub out: &'a OutFolder,
    /// Once true, the run ends after the running step.
    pub stop: &'a AtomicBool,
    /// Called before each cell with the number of cells that are done, and its name.
    pub report: &'a dyn Fn(usize, &str),
}

/// What a run has yielded.
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
    /// How often a volume was encoded, as baseline or by a codec.
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

/// Why a run cannot go on at all; a cell that fails is no such case.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct RunError(pub String);

/// A cell and its number.
#[derive(Copy, Clone)]
pub(super) struct Numbered<'a> {
    pub(super) index: usize,
    pub(super) cell: &'a Cell,
}

impl<'a> Run<'a> {
    /// Runs every cell that is not taken over.
    ///
    /// # Errors
    /// When results cannot be written, or the baseline of a volume cannot be prepared for want of the codec `raw`.
    pub fn run(&self, provenance: Provenance) -> Result<Outcome, RunError> {
        let refused = self.resolution.refused.iter().map(refused_cell).collect();
        let mut ledger =
            Ledger::new(self.out, &self.resolution.cells, |c| self.frames(c), refused, provenance);
        if self.out.resumes() {
            for volume in self.volumes {
                for Numbered { index, cell } in self.cells_of(volume) {
                    let expected = self.empty_record(cell, volume, self.target);
                    ledger.take_over(index, cell, &self.keys().of(cell, volume, self.target), &expected);
                }
            }
            ledger.tell_flawed();
            // Whatever ends this run, its results list what it took over.
            ledger.write()?;
        }
        let mut target = self.target.clone();
        // Why nothing draws any more.
        let mut gone = None;
        for volume in self.volumes {
            self.volume(volume, &mut target, &mut gone, &mut ledger)?;
        }
        // A run that was stopped before its first cell leaves what was there before.
        if !self.stopped() {
            self.out.begin().map_err(|e| RunError(e.to_string()))?;
        }
        ledger.write()?;
        Ok(ledger.into_outcome())
    }

    /// Runs what is left of a volume, on as many devices as it takes: a lost one costs the cell that ran, and is
    /// opened anew once for those that follow.
    fn volume(
        &self,
        volume: &LoadedVolume,
        target: &mut Target,
        gone: &mut Option<String>,
        ledger: &mut Ledger<'_>,
    ) -> Result<(), RunError> {
        loop {
            let left: Vec<_> = self.cells_of(volume).filter(|n| !ledger.has(n.index)).collect();
            if let Some(problem) = gone {
                return self.fail(&left, volume, target, problem, ledger);
            }
            VolumeRun { run: self, volume, target }.run(&left, ledger)?;
            let Some(reason) = target.lost() else { return Ok(()) };
            // Another device would measure another thing under the same run.
            let same = |fresh: Target| {
                let is_same = (fresh.name(), fresh.driver()) == (target.name(), target.driver());
                if is_same { Ok(fresh) } else { Err(format!("there is only {}", fresh.name())) }
            };
            match (self.reopen)().and_then(same) {
                Ok(fresh) => *target = fresh,
                Err(problem) => {
                    *gone =
                        Some(format!("the device was lost: {reason}; it cannot be opened anew: {problem}"));
                }
            }
            if self.stopped() {
                return Ok(());
            }
            if left.iter().all(|n| !ledger.has(n.index)) {
                // Not even the baseline was drawn, and another round would end likewise.
                let problem = format!("the device was lost: {reason}");
                return self.fail(&left, volume, target, &problem, ledger);
            }
        }
    }

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

    /// A record with all that is known of a cell before it runs.
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

fn refused_cell(refusal: &Refusal) -> RefusedCell {
    let Refusal { cell, reason } = refusal;
    RefusedCell {
        volume: cell.volume.clone(),
        codec: cell.codec_label(),
        settings: cell.settings.to_string(),
        site: cell.site.name().to_owned(),
        filter: cell.filter.name().to_owned(),
        renderer: cell.renderer.clone(),
        scene: cell.scene.clone(),
        skipping: cell.skipping,
        stages: cell.stages,
        reason: reason.to_string(),
    }
}
