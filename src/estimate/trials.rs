//! All trials. Each runs once, within its time limit.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use cvr_core::codec::Settings;
use cvr_core::pipeline::{Cell, Scene};
use cvr_core::volume::VolumeLayout;

use super::allowance::{Allowance, Spending, within};
use super::trial::{Frames, SIDES, TRIAL_EDGE, Trial};
use crate::registry::Names;
use crate::site::target::Target;

/// A trial with less time than this is not started.
const LEAST: Duration = Duration::from_millis(20);

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
        let stop = Arc::new(AtomicBool::new(false));
        let (start, stopped) = (Instant::now(), stop.clone());
        let (given, shape) = (settings.clone(), (layout.sample, layout.channels));
        let (mut trials, ended) =
            within(left, move |tell| Trial::grow(own.as_ref(), &given, shape, (left, &stopped), tell));
        stop.store(true, Ordering::Relaxed);
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
        let (drawn, ended) = within(left, move |tell| pictures.grow(left, tell));
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
mod tests {
    use cvr_core::codec::Site;
    use cvr_core::volume::{Extent, SampleType};

    use super::*;

    #[test]
    fn a_trial_says_what_a_codec_makes_of_a_voxel() {
        let names = Names::new().unwrap();
        let mut trials = Trials::new(&names, UNBOUNDED);
        let layout = VolumeLayout::scalar(Extent::cube(100).unwrap(), SampleType::U16);
        let raw = names.codecs().get("raw").unwrap().info().default_settings();
        let raw = trials.of("raw", &raw, &layout).unwrap();
        assert!((raw.stream_bytes_per_voxel() - 2.0).abs() < 0.05);
        let raw = raw.coded("raw");
        assert_eq!((raw.texel_bytes(), raw.buffer_bytes_per_voxel().unwrap()), (2, 2.0));
        let colour = VolumeLayout { channels: 3, sample: SampleType::U8, ..layout.clone() };
        let raw = names.codecs().get("raw").unwrap().info().default_settings();
        assert_eq!(trials.of("raw", &raw, &colour).unwrap().coded("raw").texel_bytes(), 4);
        let s3dc = names.codecs().get("s3dc").unwrap().info().default_settings();
        let s3dc = trials.of("s3dc", &s3dc, &layout).unwrap();
        // 4 bits per index, and two endpoints per block of 16³.
        assert!((s3dc.coded("s3dc").buffer_bytes_per_voxel().unwrap() - 0.5).abs() < 0.01);
        assert!(s3dc.encode_seconds_per_voxel() > 0.0 && s3dc.decode_seconds_per_voxel() > 0.0);
        // Half a byte per voxel as blocks, if the target supports them; 16 bits if decoded.
        let bc4 = names.codecs().get("bc4").unwrap().info().default_settings();
        let bc4 = trials.of("bc4", &bc4, &layout).unwrap().coded("bc4");
        assert_eq!(bc4.buffer_bytes_per_voxel().unwrap(), 0.5);
        let host = crate::site::of(Site::Host).device_bytes(bc4, &Target::Cpu { reason: None }, &layout);
        assert_eq!(host, Ok(2.0 * 100.0 * 100.0 * 100.0));
        assert!(trials.of("none", &Settings::default(), &layout).is_err());
    }

    /// However slow the machine is that runs this test.
    const UNBOUNDED: Allowance =
        Allowance { each: Duration::from_secs(3600), all: Duration::from_secs(3600) };

    #[test]
    fn without_time_nothing_is_tried_and_that_is_said() {
        let names = Names::new().unwrap();
        let none = Allowance { each: Duration::ZERO, all: Duration::ZERO };
        let mut trials = Trials::new(&names, none);
        let layout = VolumeLayout::scalar(Extent::cube(100).unwrap(), SampleType::U16);
        let raw = names.codecs().get("raw").unwrap().info().default_settings();
        assert_eq!(trials.of("raw", &raw, &layout).unwrap_err(), "no time left to encode");
        assert_eq!(trials.costs().len(), 1);
        assert_eq!(trials.costs()[0].lacks.as_deref(), Some("no time left to encode"));
    }
}
