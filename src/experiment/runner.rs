//! Running an experiment: volume by volume, codec by codec, cell by cell. Every cell's result is on disk before
//! the next one begins.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cvr_core::codec::{Codec, Progress, Settings, Site};
use cvr_core::pipeline::{Cell, Experiment, Refusal, Resolution};
use cvr_core::render::{Filter, Renderer};

use super::cell_run::{self, IMAGES, empty_record, record_encoding, write_picture};
use super::encoded::{Encoded, encode};
use super::provenance::{Provenance, ReferencePicture, RefusedCell};
use super::record::{Record, Status};
use super::results::{write_csv, write_json, write_whole};
use super::stage::{RAW, RawVolume, Stage};
use super::target::{HostVolume, Target};
use super::volumes::LoadedVolume;
use crate::registry::{Names, renderer};

/// Folder of the single records, below the report's.
pub const CELLS: &str = "cells";

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
    /// Where results go; exists.
    pub folder: &'a Path,
    /// Called before each cell with its number, from 0, and its name.
    pub report: &'a dyn Fn(usize, &str),
}

/// What a run has yielded.
#[derive(Debug)]
pub struct Outcome {
    /// One record per cell, in the order of the cells.
    pub records: Vec<Record>,
    /// The cells that could not exist.
    pub refused: Vec<RefusedCell>,
    /// Provenance with the reference pictures.
    pub provenance: Provenance,
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

impl Run<'_> {
    /// Runs every cell.
    ///
    /// # Errors
    /// When results cannot be written, or the baseline of a volume cannot be prepared for want of the codec `raw`.
    pub fn run(&self, provenance: Provenance) -> Result<Outcome, RunError> {
        let refused = self.resolution.refused.iter().map(refused_cell).collect();
        let mut outcome = Outcome { records: Vec::new(), refused, provenance };
        for name in [IMAGES, CELLS] {
            let folder = self.folder.join(name);
            // What an earlier run left here would pass for a result of this one.
            let _ = std::fs::remove_dir_all(&folder);
            std::fs::create_dir_all(&folder).map_err(|e| RunError(format!("{}: {e}", folder.display())))?;
        }
        for volume in self.volumes {
            let cells: Vec<&Cell> =
                self.resolution.cells.iter().filter(|c| c.volume == volume.name).collect();
            if !cells.is_empty() {
                self.volume(volume, &cells, &mut outcome)?;
            }
        }
        self.write(&outcome)?;
        Ok(outcome)
    }

    fn codec(&self, id: &str) -> Result<&Arc<dyn Codec>, RunError> {
        self.names.codecs().get(id).map_err(|e| RunError(e.to_string()))
    }

    fn encode(&self, id: &str, settings: &Settings, volume: &LoadedVolume) -> Result<Encoded, String> {
        let codec = self.codec(id).map_err(|e| e.to_string())?;
        encode(codec.as_ref(), settings, &volume.volume, self.folder, &Progress::silent())
    }

    fn volume(&self, volume: &LoadedVolume, cells: &[&Cell], outcome: &mut Outcome) -> Result<(), RunError> {
        let settings = self.codec(RAW)?.info().default_settings();
        let raw = self
            .encode(RAW, &settings, volume)
            .and_then(|encoded| RawVolume::new(self.target, encoded).map_err(|e| e.to_string()));
        let raw = match raw {
            Ok(raw) => raw,
            Err(problem) => {
                let problem = format!("the uncompressed volume cannot be drawn: {problem}");
                for cell in cells {
                    self.finish(
                        cell,
                        empty_record(cell, &volume.volume, self.target),
                        Err(problem.clone()),
                        outcome,
                    )?;
                }
                return Ok(());
            }
        };
        let renderers: BTreeMap<&str, Arc<dyn Renderer>> =
            cells.iter().filter_map(|c| Some((c.renderer.as_str(), renderer(&c.renderer)?))).collect();
        let mut stages = self.stages(volume, cells, &raw, &renderers, outcome)?;
        let mut rest = cells;
        while let Some(first) = rest.first() {
            let same = |c: &&&Cell| c.codec == first.codec && c.settings == first.settings;
            let count = rest.iter().take_while(same).count();
            self.codec_cells(volume, &rest[..count], &mut stages, outcome)?;
            rest = &rest[count..];
        }
        Ok(())
    }

    /// A stage for each scene and renderer of a volume.
    fn stages<'a>(
        &'a self,
        volume: &LoadedVolume,
        cells: &[&'a Cell],
        raw: &'a RawVolume,
        renderers: &'a BTreeMap<&str, Arc<dyn Renderer>>,
        outcome: &mut Outcome,
    ) -> Result<Stages<'a>, RunError> {
        let mut stages = Stages::new();
        for cell in cells {
            let key = (cell.scene.as_str(), cell.renderer.as_str());
            if stages.contains_key(&key) {
                continue;
            }
            let stage = match (self.experiment.scene(&cell.scene), renderers.get(cell.renderer.as_str())) {
                (Some(scene), Some(renderer)) => {
                    Stage::new(self.target, renderer.as_ref(), scene, &volume.volume, raw)
                }
                _ => Err(format!("no scene `{}` or no renderer `{}`", cell.scene, cell.renderer)),
            };
            if let Ok(stage) = &stage {
                let id = format!(
                    "reference-{}",
                    Cell { codec: String::new(), settings: Settings::default(), ..(*cell).clone() }.id()
                );
                let image = write_picture(self.folder, &id, &stage.reference, stage.background())
                    .map_err(RunError)?;
                outcome.provenance.references.push(ReferencePicture {
                    volume: cell.volume.clone(),
                    scene: cell.scene.clone(),
                    renderer: cell.renderer.clone(),
                    image,
                });
            }
            stages.insert(key, stage);
        }
        Ok(stages)
    }

    /// The cells of one codec and setting, which share what was encoded.
    fn codec_cells<'a>(
        &self,
        volume: &LoadedVolume,
        cells: &[&'a Cell],
        stages: &mut Stages<'a>,
        outcome: &mut Outcome,
    ) -> Result<(), RunError> {
        (self.report)(outcome.records.len(), &cells[0].id());
        let encoded = self.encode(&cells[0].codec, &cells[0].settings, volume);
        let parity = encoded.as_ref().map_err(Clone::clone).and_then(|encoded| {
            if cells.iter().any(|c| c.site == Site::Inline) {
                let use_cell = cells.iter().any(|c| c.filter == Filter::OptimisedLinear);
                return encoded.parity(&cells[0].codec, self.target, use_cell);
            }
            Ok(None)
        });
        let wants_host = cells.iter().any(|c| c.site == Site::Host);
        let host = encoded.as_ref().map_err(Clone::clone).and_then(|encoded| {
            let upload = || self.target.upload(encoded.decoder.as_ref(), encoded.frame.clone());
            wants_host.then(upload).transpose().map_err(|e| e.to_string())
        });
        for cell in cells {
            (self.report)(outcome.records.len(), &cell.id());
            let mut record = empty_record(cell, &volume.volume, self.target);
            let stage = stages.get_mut(&(cell.scene.as_str(), cell.renderer.as_str()));
            let result = match (&encoded, stage) {
                (Ok(encoded), Some(Ok(stage))) => {
                    record_encoding(&mut record, encoded, parity.as_ref().ok().copied().flatten());
                    self.cell(&mut record, cell, encoded, &host, &parity, stage)
                }
                (Err(problem), _) => Err(problem.clone()),
                (_, Some(Err(problem))) => Err(problem.clone()),
                (_, None) => Err("the scene was not prepared".to_owned()),
            };
            self.finish(cell, record, result, outcome)?;
        }
        Ok(())
    }

    fn cell(
        &self,
        record: &mut Record,
        cell: &Cell,
        encoded: &Encoded,
        host: &Result<Option<HostVolume>, String>,
        parity: &Result<Option<u64>, String>,
        stage: &mut Stage<'_>,
    ) -> Result<(), String> {
        let host = match cell.site {
            Site::Host => host.clone()?,
            _ => None,
        };
        cell_run::run(record, cell, encoded, host, stage, self.folder)?;
        encoded.check_promises()?;
        match (cell.site, parity.clone()?) {
            (Site::Inline, Some(mismatches)) if mismatches > 0 => Err(format!(
                "shader and CPU decoder disagree on {mismatches} samples beyond the codec's statement"
            )),
            _ => Ok(()),
        }
    }

    /// Puts a record on disk, alone and among the others.
    fn finish(
        &self,
        cell: &Cell,
        mut record: Record,
        result: Result<(), String>,
        outcome: &mut Outcome,
    ) -> Result<(), RunError> {
        match result {
            Ok(()) => record.status = Status::Ok,
            Err(problem) => record.error = Some(problem),
        }
        let text = serde_json::to_vec_pretty(&record).map_err(|e| RunError(e.to_string()))?;
        let path: PathBuf = self.folder.join(CELLS).join(format!("{}.json", cell.id()));
        write_whole(&path, &text).map_err(|e| RunError(e.to_string()))?;
        outcome.records.push(record);
        self.write(outcome)
    }

    fn write(&self, outcome: &Outcome) -> Result<(), RunError> {
        let fail = |e: super::results::ResultsError| RunError(e.to_string());
        write_csv(&self.folder.join("results.csv"), &outcome.records).map_err(fail)?;
        let json = self.folder.join("results.json");
        write_json(&json, &outcome.provenance, &outcome.records, &outcome.refused).map_err(fail)
    }
}

type Stages<'a> = BTreeMap<(&'a str, &'a str), Result<Stage<'a>, String>>;

fn refused_cell(refusal: &Refusal) -> RefusedCell {
    let Refusal { cell, reason } = refusal;
    RefusedCell {
        volume: cell.volume.clone(),
        codec: cell.codec.clone(),
        settings: cell.settings.to_string(),
        site: cell.site.name().to_owned(),
        filter: cell.filter.name().to_owned(),
        renderer: cell.renderer.clone(),
        scene: cell.scene.clone(),
        reason: reason.to_string(),
    }
}
