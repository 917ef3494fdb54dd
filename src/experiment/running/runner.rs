//! Running an experiment: volume by volume, codec by codec, cell by cell. Every result is on disk before the next cell
//! begins. So a process that ends loses at most the running cell.

use cvr_core::pipeline::Refusal;

use super::ledger::Ledger;
use super::outcome::{Outcome, RunError};
use super::run::{Numbered, Run};
use super::volume_run::VolumeRun;
use crate::experiment::inputs::volumes::LoadedVolume;
use crate::experiment::records::provenance::{Provenance, RefusedCell};
use crate::site::target::Target;

impl Run<'_> {
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
            // However this run ends, its results list the cells that it took over.
            ledger.write()?;
        }
        let mut target = self.target.clone();
        // Why nothing draws any more.
        let mut gone = None;
        for volume in self.volumes {
            self.volume(volume, &mut target, &mut gone, &mut ledger)?;
        }
        // A run that was stopped before its first cell leaves the old results.
        if !self.stopped() {
            self.out.begin().map_err(|e| RunError(e.to_string()))?;
        }
        ledger.write()?;
        Ok(ledger.into_outcome())
    }

    /// Runs the remaining cells of a volume. A lost device costs the running cell, and is opened again for the
    /// following ones.
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
        resolution: cell.resolution,
        reason: reason.to_string(),
    }
}
