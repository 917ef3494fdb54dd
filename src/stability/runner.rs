//! Measuring the atlas cell by cell. Each cell lies in a file of its own before another begins on its thread, under a key
//! of all that goes into it, so that a run that ends early costs no more than the cells that were running.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use cvr_core::metrics::ImageError;
use cvr_core::stability::{Trial, Trivial, Word, raw_bytes};
use cvr_core::volume::{BrickSource as _, FiniteVolume, FrameIndex};
use rayon::prelude::*;
use serde::Serialize;

use super::drawing::Stage;
use super::encoder::{self, EncoderMeasured};
use super::measured::{Ended, Measured, Pictured};
use super::plan::{Contestant, Dial, Plan};
use crate::experiment::files::cell_file::{CellFile, Keyed};
use crate::experiment::files::flaws::Flawed;
use crate::experiment::files::folder::OutFolder;
use crate::experiment::identity::key::hash_of;
use crate::experiment::records::machine;

/// Version of what the figures mean. Raised whenever a subject, a scene or a definition changes.
const ATLAS_VERSION: u32 = 2;

/// Files of results, except the cells.
pub const RESULTS: [&str; 5] = ["atlas.html", "atlas.csv", "atlas.json", "encoders.csv", "breaking.csv"];

/// Everything that a run needs.
pub struct Run<'a> {
    /// What to measure.
    pub plan: &'a Plan,
    /// Where results go.
    pub out: &'a OutFolder,
    /// Once true, the run ends after the running cells.
    pub stop: &'a AtomicBool,
    /// Called with the number of finished cells, and the name of one that begins.
    pub report: &'a (dyn Fn(usize, &str) + Sync),
}

/// Results of a run, in the order of the plan.
#[derive(Debug, Default)]
pub struct Outcome {
    /// The cells.
    pub measured: Vec<Measured>,
    /// The measurements of encoders.
    pub encoders: Vec<EncoderMeasured>,
    /// How many of both an earlier run had measured.
    pub taken_over: usize,
    /// How many of both are missing since the run was stopped.
    pub missing: usize,
}

/// All that goes into a cell.
#[derive(Serialize)]
struct Inputs<'a> {
    kind: &'a str,
    atlas_version: u32,
    version: &'a str,
    git_hash: Option<String>,
    codec: &'a str,
    settings: String,
    stream_version: u32,
    subject: &'a str,
    step: usize,
    edge: u32,
    picture: u32,
    samples_blake3: String,
    more: String,
}

impl Run<'_> {
    /// Measures every cell that is not taken over.
    ///
    /// # Errors
    /// A sentence, when the folder cannot be written or a scene cannot be drawn.
    pub fn run(&self) -> Result<Outcome, String> {
        let (done, taken_over, flawed) = (AtomicUsize::new(0), AtomicUsize::new(0), Mutex::default());
        let counts = Counts { done: &done, taken_over: &taken_over, flawed: &flawed };
        let mut outcome = Outcome::default();
        for dial in &self.plan.dials {
            for &step in &dial.steps {
                outcome.measured.extend(self.step(dial, step, counts)?);
            }
        }
        for name in &self.plan.config.encoder_subjects {
            outcome.encoders.extend(self.encoders(name, counts)?);
        }
        flawed
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
            .lines()
            .for_each(|line| eprintln!("{line}"));
        outcome.taken_over = taken_over.into_inner();
        let all = self.plan.cells() + self.plan.encoder_cells();
        outcome.missing = all - outcome.measured.len() - outcome.encoders.len();
        Ok(outcome)
    }

    /// One step of one dial: all codecs.
    fn step(&self, dial: &Dial, step: usize, counts: Counts<'_>) -> Result<Vec<Measured>, String> {
        let subject = dial.subject;
        let config = &self.plan.config;
        let blake3 = samples_hash(&subject.volume(step, config.edge));
        let wanted = self.plan.contestants.iter().map(|contestant| {
            let scenes: Vec<&str> = self.plan.scenes.iter().map(|s| s.name).collect();
            let more = format!("{scenes:?}");
            let key = self.key("cell", contestant, (subject.name, step), blake3.clone(), more);
            let id = cell_name(&contestant.label, subject.name, step + 1);
            (contestant, id, key)
        });
        let wanted: Vec<_> = wanted.collect();
        let known: Vec<Option<Measured>> =
            wanted.iter().map(|(_, id, key)| self.known(id, key, counts, Measured::file_name)).collect();
        let needed = known.iter().any(Option::is_none) && !self.stopped();
        let make = || Stage::new(subject, step, &self.plan.scenes, [config.edge, config.picture]);
        let stage = needed.then(make).transpose()?;
        let measured =
            wanted.par_iter().zip(known).map(|((contestant, id, key), known)| match (known, &stage) {
                (Some(known), _) => Ok(Some(known)),
                (None, Some(stage)) if !self.stopped() => {
                    (self.report)(counts.done.load(Ordering::Relaxed), id);
                    let measured = measure(contestant, dial, step, stage)?;
                    self.keep(id, key, measured, counts).map(Some)
                }
                _ => Ok(None),
            });
        let measured: Vec<Option<Measured>> = measured.collect::<Result<_, String>>()?;
        Ok(measured.into_iter().flatten().collect())
    }

    /// The stability of all encoders over one subject.
    fn encoders(&self, name: &str, counts: Counts<'_>) -> Result<Vec<EncoderMeasured>, String> {
        let config = &self.plan.config;
        let subject =
            cvr_core::stability::Subject::named(name).ok_or_else(|| format!("no subject `{name}`"))?;
        let step = subject.steps.len() / 2;
        let volume = subject.volume(step, config.edge);
        let blake3 = samples_hash(&volume);
        let measured = self.plan.encoders.par_iter().map(|contestant| {
            let more = format!("{} {:?} {}", config.seeds, config.threads, config.generations);
            let key = self.key("encoder", contestant, (name, step), blake3.clone(), more);
            let id = encoder_name(&contestant.label, name);
            if let Some(known) = self.known(&id, &key, counts, EncoderMeasured::file_name) {
                return Ok(Some(known));
            }
            if self.stopped() {
                return Ok(None);
            }
            (self.report)(counts.done.load(Ordering::Relaxed), &id);
            let measured = encoder::measure(contestant, (subject.name, step), &volume, config)?;
            self.keep(&id, &key, measured, counts).map(Some)
        });
        let measured: Vec<Option<EncoderMeasured>> = measured.collect::<Result<_, String>>()?;
        Ok(measured.into_iter().flatten().collect())
    }

    fn key(
        &self,
        kind: &str,
        contestant: &Contestant,
        (subject, step): (&str, usize),
        samples_blake3: String,
        more: String,
    ) -> String {
        let info = contestant.codec.info();
        hash_of(&Inputs {
            kind,
            atlas_version: ATLAS_VERSION,
            version: env!("CARGO_PKG_VERSION"),
            git_hash: machine::git_hash(),
            codec: info.id,
            settings: contestant.settings.to_string(),
            stream_version: info.stream_version,
            subject,
            step,
            edge: self.plan.config.edge,
            picture: self.plan.config.picture,
            samples_blake3,
            more,
        })
    }

    /// What an earlier run has measured; `name` gives the name of a record's own cell.
    fn known<R: Keyed>(
        &self,
        id: &str,
        key: &str,
        counts: Counts<'_>,
        name: impl Fn(&R) -> String,
    ) -> Option<R> {
        if !self.out.resumes() {
            return None;
        }
        let file = match CellFile::<R>::whole(self.out.path(), id, key, |record| name(record) == id) {
            Ok(file) => file,
            Err(flaw) => {
                counts.flawed.lock().unwrap_or_else(PoisonError::into_inner).add(flaw, id);
                return None;
            }
        };
        counts.done.fetch_add(1, Ordering::Relaxed);
        counts.taken_over.fetch_add(1, Ordering::Relaxed);
        Some(file.record)
    }

    fn keep<R: Keyed>(&self, id: &str, key: &str, record: R, counts: Counts<'_>) -> Result<R, String> {
        self.out.begin().map_err(|e| e.to_string())?;
        let file = CellFile::new(record, Some(key.to_owned()), self.out.path(), []);
        file.write(self.out, id).map_err(|e| e.to_string())?;
        counts.done.fetch_add(1, Ordering::Relaxed);
        Ok(file.record)
    }

    fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Cells that are done, and those of them that an earlier run had done.
#[derive(Copy, Clone)]
struct Counts<'a> {
    done: &'a AtomicUsize,
    taken_over: &'a AtomicUsize,
    flawed: &'a Mutex<Flawed>,
}

fn samples_hash(volume: &FiniteVolume) -> String {
    blake3::hash(volume.dense().samples().as_bytes()).to_hex().to_string()
}

/// Name of a cell; steps count from 1.
fn cell_name(label: &str, subject: &str, step: usize) -> String {
    format!("{}-{subject}-{step}", file_name(label))
}

/// Name of the measurement of an encoder.
fn encoder_name(label: &str, subject: &str) -> String {
    format!("encoder-{}-{subject}", file_name(label))
}

impl Measured {
    /// Name of its file, without ending.
    fn file_name(&self) -> String {
        cell_name(&self.label, &self.subject, self.step)
    }
}

impl EncoderMeasured {
    /// Name of its file, without ending.
    fn file_name(&self) -> String {
        encoder_name(&self.label, &self.subject)
    }
}

/// The names of all cells and measurements of a plan.
#[must_use]
pub fn names(plan: &Plan) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for dial in &plan.dials {
        for step in &dial.steps {
            let name = |c: &Contestant| cell_name(&c.label, dial.subject.name, step + 1);
            names.extend(plan.contestants.iter().map(name));
        }
    }
    for subject in &plan.config.encoder_subjects {
        names.extend(plan.encoders.iter().map(|c| encoder_name(&c.label, subject)));
    }
    names
}

/// A label as part of a file's name.
fn file_name(label: &str) -> String {
    label.chars().map(|c| if c.is_ascii_alphanumeric() || ".=_".contains(c) { c } else { '-' }).collect()
}

/// Takes one step through one codec, and draws it.
fn measure(contestant: &Contestant, dial: &Dial, step: usize, stage: &Stage) -> Result<Measured, String> {
    let volume = stage.volume();
    let layout = volume.layout();
    let trial = Trial::of(contestant.codec.as_ref(), &contestant.settings, volume);
    let trivial = trial.trivial(volume);
    let observed = trial.observed(volume, trivial.as_ref(), false);
    let (word, problem) = match observed.word {
        Word::Kept => (Ended::Kept, None),
        Word::Refused(why) => (Ended::Refused, Some(why)),
        Word::Broken(why) => (Ended::Broken, Some(why)),
    };
    let finite = |value: f64| value.is_finite().then_some(value);
    Ok(Measured {
        codec: contestant.codec.info().id.to_owned(),
        label: contestant.label.clone(),
        settings: contestant.settings.to_string(),
        subject: dial.subject.name.to_owned(),
        step: step + 1,
        value: dial.subject.steps[step],
        sample: layout.sample.name().to_owned(),
        dims: layout.extent.to_array(),
        frames: layout.frames,
        word,
        problem,
        file_bytes: trial.file_bytes,
        raw_bytes: raw_bytes(layout),
        error_bound: trial.error_bound,
        max_abs_error: trial.error.and_then(|e| finite(e.max_abs_error)),
        voxel_rmse: finite(observed.voxels),
        span: volume.range().span(),
        changed_samples: (!trial.frames.is_empty()).then(|| changed(volume, &trial.frames)),
        voxel_floor: observed.voxel_floor,
        trivial_grid: trivial.as_ref().map(|t| t.grid.to_array()),
        trivial_voxel_rmse: finite(observed.trivial_voxels),
        pictures: pictures(stage, &trial, trivial.as_ref())?,
        notes: trial.notes,
    })
}

/// Share of samples that are others, integers rounded first.
fn changed(volume: &FiniteVolume, frames: &[Vec<f32>]) -> f64 {
    let integer = volume.layout().sample.is_integer();
    let count = |(decoded, frame): (&Vec<f32>, u32)| {
        let original = volume.dense().frame_values(FrameIndex(frame));
        let differs = |(d, o): &(&f32, &f32)| if integer { d.round() != **o } else { d != o };
        decoded.iter().zip(&original).filter(differs).count()
    };
    frames.iter().zip(0..).map(count).sum::<usize>() as f64 / volume.layout().samples() as f64
}

/// Figures of all scenes. A codec that decodes to nothing has no picture; the scene is listed all the same.
fn pictures(stage: &Stage, trial: &Trial, trivial: Option<&Trivial>) -> Result<Vec<Pictured>, String> {
    let own = if trial.frames.is_empty() { None } else { Some(stage.shown(&trial.frames)?) };
    let trivial = trivial.map(|t| stage.shown(&t.frames)).transpose()?;
    // If the reference shows nothing, the error counts as on one pixel.
    let rmse = |error: &ImageError| {
        let shown = error.visible_pixels.max(1) as f64;
        Some((error.squared_error() / (3.0 * shown)).sqrt()).filter(|v| v.is_finite())
    };
    let mut pictures = Vec::new();
    for scene in stage.scenes() {
        let mut pictured = Pictured {
            scene: scene.provocation.name.to_owned(),
            visible_pixels: scene.reference.pixels().iter().filter(|p| cvr_core::metrics::visible(p)).count()
                as u64,
            ..Pictured::default()
        };
        if let Some(own) = &own {
            let error = stage.error(scene, own)?;
            pictured.rmse = rmse(&error);
            pictured.ssim = error.ssim().filter(|v| v.is_finite());
        }
        if let Some(trivial) = &trivial {
            let error = stage.error(scene, trivial)?;
            pictured.trivial_rmse = rmse(&error);
        }
        pictures.push(pictured);
    }
    Ok(pictures)
}
