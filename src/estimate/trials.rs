//! All trials. Each runs once, within its time limit.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use cvr_core::codec::Settings;
use cvr_core::pipeline::{Cell, Scene};
use cvr_core::volume::VolumeLayout;

use super::allowance::{Allowance, Spending, Unfinished, within};
use super::trial::{Frames, SIDES, TRIAL_EDGE, Trial};
use crate::registry::Names;
use crate::site::target::Target;

/// A trial with less time than this is not started.
const LEAST: Duration = Duration::from_millis(20);

/// How long the end of trials that are out of time is waited for. Lavapipe compiles the slowest shader that is known in a few
/// seconds.
const LONGEST_WAIT: Duration = Duration::from_secs(60);

/// Times of one trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    /// Label of the codec in records.
    pub codec: String,
    /// Its settings.
    pub settings: String,
    /// Wall seconds.
    pub seconds: f64,
    /// What it lacks, as a sentence without its end. Estimates based on it are too low.
    pub lacks: Option<String>,
}

/// Trials that were made, each once.
pub struct Trials<'a> {
    names: &'a Names,
    report: &'a dyn Fn(&str),
    spending: Spending,
    trials: BTreeMap<String, Result<Trial, String>>,
    frames: BTreeMap<String, Result<Frames, String>>,
    /// The latest frame times of a codec at a site.
    at_site: BTreeMap<String, Frames>,
    costs: Vec<Cost>,
    /// Trials that did not end in their time.
    unfinished: Vec<Unfinished>,
}

impl<'a> Trials<'a> {
    /// No trials yet, and no reports.
    #[must_use]
    pub fn new(names: &'a Names, allowance: Allowance) -> Self {
        Self::reporting(names, allowance, &|_| {})
    }

    /// No trials yet. `report` is called before each trial.
    #[must_use]
    pub fn reporting(names: &'a Names, allowance: Allowance, report: &'a dyn Fn(&str)) -> Self {
        Self {
            names,
            report,
            spending: Spending::new(allowance),
            trials: BTreeMap::new(),
            frames: BTreeMap::new(),
            at_site: BTreeMap::new(),
            costs: Vec::new(),
            unfinished: Vec::new(),
        }
    }

    /// The trials and their times.
    #[must_use]
    pub fn costs(&self) -> &[Cost] {
        &self.costs
    }

    /// The trial of a codec with settings for volumes of this layout.
    ///
    /// # Errors
    /// A sentence, when the codec or the disk refuses, or there was no time.
    pub fn of(&mut self, codec: &str, settings: &Settings, layout: &VolumeLayout) -> Result<&Trial, String> {
        let key = trial_key(codec, settings, layout);
        if !self.trials.contains_key(&key) {
            let trial = self.encode(codec, settings, layout);
            self.trials.insert(key.clone(), trial);
        }
        let trial = self.trials.get(&key).ok_or("not tried")?;
        trial.as_ref().map_err(Clone::clone)
    }

    fn encode(&mut self, codec: &str, settings: &Settings, layout: &VolumeLayout) -> Result<Trial, String> {
        let own = self.names.codecs().get(codec).map_err(|e| e.to_string())?.clone();
        let site = format!("{codec} encode");
        let left = self.spending.left(&site);
        if left < LEAST {
            return Err(self.skipped(codec, settings, "encode"));
        }
        (self.report)(&format!("{codec} {settings}: encode"));
        let start = Instant::now();
        let (given, shape) = (settings.clone(), (layout.sample, layout.channels));
        let (mut trials, ended) =
            self.within(left, move |tell, stop| Trial::grow(own.as_ref(), &given, shape, (left, stop), tell));
        self.spending.add(&site, start.elapsed());
        let trial = trials.pop().unwrap_or_else(|| Err(unfinished(ended, "encode", left)));
        let lacks = match &trial {
            Ok(trial) if trial.edge < TRIAL_EDGE => Some(format!("encoded {}³ voxels alone", trial.edge)),
            Ok(_) => None,
            Err(problem) => Some(problem.clone()),
        };
        self.cost(codec, settings, start.elapsed(), lacks);
        trial
    }

    /// Frame times of a cell. Scenes that differ in size, camera or colours share a measurement. If there was no time
    /// for one, other frame times of the codec at this site replace it.
    ///
    /// # Errors
    /// As [`Trials::of`], and when the target refuses.
    pub fn frames(
        &mut self,
        target: &Target,
        cell: &Cell,
        scene: &Scene,
        layout: &VolumeLayout,
    ) -> Result<Frames, String> {
        let lit = if scene.shading.is_some() { "lit" } else { "unlit" };
        let trial = trial_key(&cell.codec, &cell.settings, layout);
        let way = format!("{} {} {} {lit}", cell.renderer, cell.site, cell.filter);
        let key = format!("{trial} {way}");
        if let Some(known) = self.frames.get(&key) {
            return known.clone();
        }
        let frames = self.draw(target, cell, scene, layout, &way);
        self.frames.insert(key, frames.clone());
        frames
    }

    fn draw(
        &mut self,
        target: &Target,
        cell: &Cell,
        scene: &Scene,
        layout: &VolumeLayout,
        way: &str,
    ) -> Result<Frames, String> {
        let pictures = self.of(&cell.codec, &cell.settings, layout)?.pictures(target, cell, scene)?;
        let site = format!("{} {}", cell.codec, cell.site);
        let left = self.spending.left(&site);
        if left < LEAST {
            let skipped = self.skipped(&cell.codec, &cell.settings, &format!("draw {way}"));
            return self.at_site.get(&site).copied().ok_or(skipped);
        }
        (self.report)(&format!("{} {}: draw {way}", cell.codec, cell.settings));
        let start = Instant::now();
        let (drawn, ended) = self.within(left, move |tell, stop| pictures.grow((left, stop), tell));
        self.spending.add(&site, start.elapsed());
        let count = drawn.len();
        let frames = match drawn.into_iter().collect::<Result<Vec<_>, _>>() {
            Ok(drawn) => Frames::of(&drawn).ok_or_else(|| unfinished(ended, &format!("draw {way}"), left)),
            Err(problem) => Err(problem),
        };
        let lacks = match &frames {
            Ok(_) if count < SIDES.len() => Some(format!("drew {}² pixels alone, {way}", SIDES[count - 1])),
            Ok(_) => None,
            Err(problem) => Some(problem.clone()),
        };
        if let Ok(frames) = &frames {
            self.at_site.insert(site, *frames);
        }
        self.cost(&cell.codec, &cell.settings, start.elapsed(), lacks);
        frames
    }

    /// Waits for the threads of trials that did not end in their time, for one minute at most. A process that ends while one
    /// of them compiles or draws may end in its driver, by a signal.
    pub fn end(&mut self) {
        if !self.unfinished.is_empty() {
            (self.report)("ending what was not done in its time");
        }
        let end = Instant::now() + LONGEST_WAIT;
        for unfinished in self.unfinished.drain(..) {
            _ = unfinished.end(end.saturating_duration_since(Instant::now()));
        }
    }

    /// What work has told within its time, and whether it has ended; where it has not, its thread is waited for later.
    fn within<T: Send + 'static>(
        &mut self,
        limit: Duration,
        work: impl FnOnce(&Sender<T>, &AtomicBool) + Send + 'static,
    ) -> (Vec<T>, bool) {
        let (told, unfinished) = within(limit, work);
        let ended = unfinished.is_none();
        self.unfinished.extend(unfinished);
        (told, ended)
    }

    fn cost(&mut self, codec: &str, settings: &Settings, took: Duration, lacks: Option<String>) {
        let (codec, settings) = (codec.to_owned(), settings.to_string());
        self.costs.push(Cost { codec, settings, seconds: took.as_secs_f64(), lacks });
    }

    fn skipped(&mut self, codec: &str, settings: &Settings, what: &str) -> String {
        let problem = format!("no time left to {what}");
        self.cost(codec, settings, Duration::ZERO, Some(problem.clone()));
        problem
    }
}

impl Drop for Trials<'_> {
    fn drop(&mut self) {
        self.end();
    }
}

fn unfinished(ended: bool, what: &str, left: Duration) -> String {
    match ended {
        true => format!("the trial to {what} ended without a result"),
        false => format!("the trial to {what} did not end in {:.1} s and was left", left.as_secs_f64()),
    }
}

fn trial_key(codec: &str, settings: &Settings, layout: &VolumeLayout) -> String {
    format!("{codec} {settings} {} {}", layout.sample, layout.channels)
}

#[cfg(test)]
mod tests;
