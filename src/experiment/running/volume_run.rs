//! The cells of one volume on one device: baseline, stages, and codec by codec.

use std::collections::BTreeMap;
use std::sync::Arc;

use cvr_core::codec::{Codec, Progress, Settings};
use cvr_core::pipeline::Cell;
use cvr_core::render::Renderer;
use cvr_core::volume::Level;

use super::cell_run::{self, record_encoding};
use super::encoded::{Encoded, encode};
use super::frame_run::FrameRun;
use super::ledger::Ledger;
use super::outcome::RunError;
use super::run::{Numbered, Run};
use super::shared::Shared;
use super::stage::{RawVolume, Stage};
use crate::experiment::files::names::of_id;
use crate::experiment::inputs::volumes::LoadedVolume;
use crate::experiment::measured::reference::RAW;
use crate::experiment::shards::shard::same_group;
use crate::registry::renderer;
use crate::site::target::Target;

type Stages<'a> = BTreeMap<(&'a str, &'a str), Result<Stage<'a>, String>>;

/// One volume on one device. Ends early if the run is stopped or the device is lost. Cells that are then not in the
/// ledger have not run.
pub(super) struct VolumeRun<'a> {
    pub(super) run: &'a Run<'a>,
    pub(super) volume: &'a LoadedVolume,
    pub(super) target: &'a Target,
}

impl<'a> VolumeRun<'a> {
    /// Runs these cells of the volume, and draws missing references of others. If nothing is missing, nothing is
    /// encoded.
    pub(super) fn run(&self, cells: &[Numbered<'a>], ledger: &mut Ledger<'_>) -> Result<(), RunError> {
        let staged: Vec<&Cell> = self
            .run
            .cells_of(self.volume)
            .filter(|n| !ledger.has(n.index) || !ledger.has_reference(n.cell))
            .map(|n| n.cell)
            .collect();
        if staged.is_empty() || self.run.stopped() {
            return Ok(());
        }
        (self.run.report)(ledger.done(), &staged[0].id());
        let settings = self.codec(RAW)?.info().default_settings();
        let raw = match self.encode(RAW, &settings, ledger) {
            Ok(encoded) => RawVolume::new(encoded),
            Err(_) if self.run.stopped() => return Ok(()),
            Err(problem) => {
                let problem = format!("the uncompressed volume cannot be drawn: {problem}");
                return self.run.fail(cells, self.volume, self.target, &problem, ledger);
            }
        };
        let renderers: BTreeMap<&str, Arc<dyn Renderer>> =
            staged.iter().filter_map(|c| Some((c.renderer.as_str(), renderer(&c.renderer).ok()?))).collect();
        let mut stages = self.stages(&staged, &raw, &renderers, ledger)?;
        for group in cells.chunk_by(|a, b| same_group(a.cell, b.cell)) {
            if self.must_end() {
                return Ok(());
            }
            self.codec_cells(group, &mut stages, ledger)?;
        }
        Ok(())
    }

    fn must_end(&self) -> bool {
        self.run.stopped() || self.target.lost().is_some()
    }

    fn codec(&self, id: &str) -> Result<&'a Arc<dyn Codec>, RunError> {
        self.run.names.codecs().get(id).map_err(|e| RunError(e.to_string()))
    }

    fn encode(&self, id: &str, settings: &Settings, ledger: &mut Ledger<'_>) -> Result<Encoded, String> {
        let codec = self.codec(id).map_err(|e| e.to_string())?;
        ledger.encodings += 1;
        let progress = Progress::new(|_| {}, Some(self.run.stop));
        let place = (self.run.out.path(), self.run.experiment.decoded_frames_mb);
        encode(codec.as_ref(), settings, &self.volume.volume, place, &progress)
    }

    /// A stage for each scene and renderer of these cells.
    fn stages<'b>(
        &self,
        cells: &[&'b Cell],
        raw: &'b RawVolume,
        renderers: &'b BTreeMap<&str, Arc<dyn Renderer>>,
        ledger: &mut Ledger<'_>,
    ) -> Result<Stages<'b>, RunError>
    where
        'a: 'b,
    {
        let mut stages = Stages::new();
        for cell in cells {
            let key = (cell.scene.as_str(), cell.renderer.as_str());
            if stages.contains_key(&key) || self.run.stopped() {
                continue;
            }
            let scene = self.run.experiment.scene(&cell.scene);
            let stage = match (scene, renderers.get(cell.renderer.as_str())) {
                (Some(scene), Some(renderer)) => {
                    Stage::new(self.target, renderer.as_ref(), scene, &self.volume.volume, raw)
                }
                _ => Err(format!("no scene `{}` or no renderer `{}`", cell.scene, cell.renderer)),
            };
            if let Ok(stage) = &stage
                && !ledger.has_reference(cell)
            {
                for (frame, path) in stage.frames().iter().zip(ledger.reference_files(cell)) {
                    let image = stage.reference(frame).map_err(RunError)?;
                    let png = image.to_png(stage.background()).map_err(|e| RunError(e.to_string()))?;
                    self.run.out.write(&path, &png).map_err(|e| RunError(e.to_string()))?;
                }
                ledger.add_reference(cell);
            }
            stages.insert(key, stage);
        }
        Ok(stages)
    }

    /// The cells of one codec and setting, which share a stream.
    fn codec_cells<'b>(
        &self,
        cells: &[Numbered<'b>],
        stages: &mut Stages<'b>,
        ledger: &mut Ledger<'_>,
    ) -> Result<(), RunError> {
        let Numbered { cell: first, .. } = cells[0];
        (self.run.report)(ledger.done(), &first.id());
        let encoded = self.encode(&first.codec, &first.settings, ledger);
        if self.run.stopped() {
            return Ok(());
        }
        let mut levels: Vec<Level> = Vec::new();
        cells.iter().map(|n| n.cell.level()).for_each(|level| {
            if !levels.contains(&level) {
                levels.push(level);
            }
        });
        for level in levels {
            if self.must_end() {
                break;
            }
            let of_level: Vec<Numbered<'b>> =
                cells.iter().copied().filter(|n| n.cell.level() == level).collect();
            // All stages are already decoded.
            let at_level = match &encoded {
                Ok(encoded) if level != encoded.level => Some(encoded.at(level, &self.volume.volume)),
                _ => None,
            };
            self.level_cells(&of_level, at_level.as_ref().unwrap_or(&encoded), stages, ledger)?;
        }
        Ok(())
    }

    /// The cells that draw one level.
    fn level_cells<'b>(
        &self,
        cells: &[Numbered<'b>],
        encoded: &Result<Encoded, String>,
        stages: &mut Stages<'b>,
        ledger: &mut Ledger<'_>,
    ) -> Result<(), RunError> {
        let Numbered { cell: first, .. } = cells[0];
        let shared = encoded
            .as_ref()
            .map(|encoded| Shared::new(self.target, &first.codec, encoded, cells.iter().map(|n| n.cell)));
        for &Numbered { index, cell } in cells {
            if self.run.stopped() {
                break;
            }
            (self.run.report)(ledger.done(), &cell.id());
            let mut record = self.run.empty_record(cell, self.volume, self.target);
            // Listed all at once, because each entry of the list is synced.
            let names = of_id(&cell.id());
            let announced = self.run.out.announce(&names.each_ref().map(String::as_str));
            announced.map_err(|e| RunError(e.to_string()))?;
            let stage = stages.get_mut(&(cell.scene.as_str(), cell.renderer.as_str()));
            let result = match (&shared, stage) {
                (Ok(shared), Some(Ok(stage))) => {
                    record_encoding(&mut record, shared.encoded());
                    let run = FrameRun { cell, shared, out: self.run.out, stop: self.run.stop };
                    cell_run::run(&mut record, &run, stage)
                }
                (Err(problem), _) => Err((*problem).clone()),
                (_, Some(Err(problem))) => Err(problem.clone()),
                (_, None) => Err("the scene was not prepared".to_owned()),
            };
            if result.is_err() && self.run.stopped() {
                break;
            }
            let key = self.run.keys().of(cell, self.volume, self.target);
            ledger.finish(index, cell, record, key, result)?;
            // Every later cell on this device would fail likewise.
            if self.target.lost().is_some() {
                break;
            }
        }
        Ok(())
    }
}
