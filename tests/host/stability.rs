//! The stability atlas: all measurements of `cvr stability --quick`; runs that stop and resume; a codec that breaks its
//! promise.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use cvr::experiment::files::folder::{Existing, OutFolder};
use cvr::registry::codecs;
use cvr::stability::atlas::Atlas;
use cvr::stability::claim::claim;
use cvr::stability::config::Config;
use cvr::stability::plan::Plan;
use cvr::stability::report::{self, Provenance};
use cvr::stability::row::VOXELS;
use cvr::stability::runner::{Outcome, Run};
use cvr_core::codec::{
    Codec, CodecInfo, ConfigError, DecodeError, Decoder, EncodeError, EncodeReport, Encoder, Progress,
    Registry, SettingValue, Settings,
};
use cvr_core::container::{EncodedVolume, StreamWriter};
use cvr_core::stability::{Reason, Subject, Verdict};
use cvr_core::volume::BrickSource;

use super::folder::Folder;

const CONFIG: &str = r#"
edge = 16
picture = 24
steps = 2
scenes = ["slope-3", "noise-floor"]
seeds = 2
threads = [1, 3]
generations = 2
encoder_subjects = ["noise"]
"#;

/// A plan over some subjects and codecs, smaller than a useful measurement.
fn plan(subjects: &[&str], ids: &[&str]) -> Plan {
    let text = format!("subjects = {subjects:?}\n{CONFIG}");
    let ids: Vec<String> = ids.iter().map(|id| (*id).to_owned()).collect();
    Plan::new(Config::parse("tiny.toml", &text).unwrap(), &codecs().unwrap(), &ids).unwrap()
}

fn open(plan: &Plan, folder: &Path, existing: Existing) -> OutFolder {
    OutFolder::open(folder, &claim(plan), existing).unwrap()
}

fn run(plan: &Plan, folder: &Path, resume: bool) -> Outcome {
    let out = open(plan, folder, Existing::of(resume, true));
    Run { plan, out: &out, stop: &AtomicBool::new(false), report: &|_, _| {} }.run().unwrap()
}

#[test]
fn every_codec_goes_through_every_volume_and_keeps_its_word() {
    let (folder, registry) = (Folder::new(), codecs().unwrap());
    let plan = Plan::new(Config::own().unwrap().quick(), &registry, &[]).unwrap();
    let outcome = run(&plan, folder.root(), false);
    assert_eq!(plan.dials.len(), Subject::all().count());
    let steps: usize = Subject::all().map(|subject| subject.steps.len().min(3)).sum();
    assert!(plan.contestants.len() > registry.iter().count());
    let cells = plan.contestants.len() * steps;
    assert_eq!((outcome.measured.len(), outcome.missing, outcome.taken_over), (cells, 0, 0));
    assert!(outcome.encoders.len() > registry.iter().count());
    let atlas = Atlas::of(&outcome.measured);
    let broken: Vec<String> = atlas
        .broken()
        .map(|r| format!("{} {} at {}: {:?}", r.label, r.subject, r.value, r.problem))
        .collect();
    assert!(broken.is_empty(), "{broken:#?}");
    for encoder in &outcome.encoders {
        assert!(encoder.problem.is_some() || encoder.threads_agree, "{}", encoder.label);
    }
    let raw = atlas.rows.iter().filter(|r| r.codec == "raw");
    // A verdict for the voxels of each cell, and one for each of the scenes.
    let verdicts = 1 + plan.scenes.len();
    assert!(raw.clone().all(|r| r.verdict == Verdict::Holds) && raw.count() == steps * verdicts);
    // Verdicts that all were alike would prove little.
    for verdict in [Verdict::Holds, Verdict::Fails] {
        assert!(atlas.rows.iter().any(|r| r.verdict == verdict && r.scene != VOXELS), "{verdict}");
    }

    let provenance = Provenance::now(&plan);
    let out = open(&plan, folder.root(), Existing::Resume);
    atlas.write(&out, &provenance, &outcome.encoders).unwrap();
    report::write(&out, &provenance, &plan, &atlas, &outcome).unwrap();
    let page = folder.text("atlas.html");
    for codec in registry.iter() {
        assert!(page.contains(codec.info().id), "{}", codec.info().id);
    }
    for subject in Subject::all() {
        assert!(page.contains(subject.name), "{}", subject.name);
        assert!(folder.names().contains(&format!("charts/dial-{}.svg", subject.name)), "{}", subject.name);
    }
    assert!(
        page.contains("data:image/png;base64,") && folder.text("charts/heat-map.svg").ends_with("</svg>")
    );
    assert_eq!(folder.text("atlas.csv").lines().count(), 1 + cells * verdicts);
    assert_eq!(folder.text("breaking.csv").lines().count(), 1 + plan.contestants.len() * plan.dials.len());
    assert_eq!(folder.json("atlas.json")["verdicts"].as_array().unwrap().len(), cells * verdicts);
}

#[test]
fn what_is_measured_is_taken_over_and_what_is_damaged_is_not() {
    let (folder, plan) = (Folder::new(), plan(&["ramp", "slab"], &["raw", "s3dc"]));
    let first = run(&plan, folder.root(), false);
    let all = plan.cells() + plan.encoder_cells();
    let again = run(&plan, folder.root(), true);
    assert_eq!((again.taken_over, &again.measured, &again.encoders), (all, &first.measured, &first.encoders));
    let cell = folder.text("cells/s3dc-slab-5.json");
    let unsealed = cell.replacen("\"digest\"", "\"another\"", 1);
    let other = folder.text("cells/s3dc-slab-1.json");
    let edited = cell.replacen("\"span\": ", "\"span\": 1", 1);
    for damaged in [&cell[..cell.len() / 2], &unsealed, &other, &edited] {
        assert_ne!(damaged, cell);
        folder.write("cells/s3dc-slab-5.json", damaged);
        let mended = run(&plan, folder.root(), true);
        assert_eq!((mended.taken_over, &mended.measured), (all - 1, &first.measured));
        assert_eq!(folder.text("cells/s3dc-slab-5.json"), cell);
    }
    // Other pictures are another atlas.
    let mut other = plan.clone();
    other.config.picture = 25;
    assert_eq!(run(&other, folder.root(), true).taken_over, 0);
    assert_eq!(run(&plan, folder.root(), false).taken_over, 0, "without --resume nothing is");
}

#[test]
fn a_run_that_is_stopped_leaves_what_it_has_and_goes_on() {
    let (folder, plan) = (Folder::new(), plan(&["ramp", "slab"], &["raw", "s3dc"]));
    let all = plan.cells() + plan.encoder_cells();
    let (stop, begun) = (AtomicBool::new(false), AtomicUsize::new(0));
    let report = |_: usize, _: &str| {
        if begun.fetch_add(1, Ordering::Relaxed) == 3 {
            stop.store(true, Ordering::Relaxed);
        }
    };
    let out = open(&plan, folder.root(), Existing::Replace);
    let stopped = Run { plan: &plan, out: &out, stop: &stop, report: &report }.run().unwrap();
    let finished = stopped.measured.len() + stopped.encoders.len();
    assert!((4..all).contains(&finished) && stopped.missing == all - finished, "{finished}");
    let atlas = Atlas::of(&stopped.measured);
    let provenance = Provenance::now(&plan);
    atlas.write(&out, &provenance, &stopped.encoders).unwrap();
    report::write(&out, &provenance, &plan, &atlas, &stopped).unwrap();
    drop(out);
    assert!(folder.text("atlas.html").contains("This run was stopped"));

    let whole = run(&plan, folder.root(), true);
    assert_eq!((whole.taken_over, whole.missing), (finished, 0));
    let other = Folder::new();
    assert_eq!(whole.measured, run(&plan, other.root(), false).measured);
}

/// `raw` in 8 bits that says it loses nothing.
#[derive(Debug)]
struct Liar(std::sync::Arc<dyn Codec>);

#[derive(Debug)]
struct LiarsEncoder(Box<dyn Encoder>);

impl Codec for Liar {
    fn info(&self) -> &CodecInfo {
        self.0.info()
    }

    fn encoder(&self, _: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        let settings: Settings = [("bits".to_owned(), SettingValue::from("8"))].into_iter().collect();
        Ok(Box::new(LiarsEncoder(self.0.encoder(&self.info().complete(&settings)?)?)))
    }

    fn decoder(&self, volume: std::sync::Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        self.0.decoder(volume)
    }
}

impl Encoder for LiarsEncoder {
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        Ok(EncodeReport { error_bound: Some(0.0), ..self.0.encode(source, out, run)? })
    }
}

#[test]
fn a_codec_that_lies_is_found() {
    let folder = Folder::new();
    let mut registry = Registry::default();
    registry.register(std::sync::Arc::new(Liar(cvr_raw::codec()))).unwrap();
    let text = format!("subjects = [\"ramp\"]\n{CONFIG}");
    let plan = Plan::new(Config::parse("tiny.toml", &text).unwrap(), &registry, &[]).unwrap();
    let outcome = run(&plan, folder.root(), false);
    let atlas = Atlas::of(&outcome.measured);
    assert_eq!(atlas.broken().count(), 2, "16 bits in 8, at both steps");
    assert!(atlas.rows.iter().all(|r| r.reason == Some(Reason::Promise) && r.verdict == Verdict::Fails));
    assert!(atlas.rows[0].problem.as_deref().unwrap().contains("promised 0"), "{:?}", atlas.rows[0].problem);
}

#[test]
fn the_list_runs_nothing_and_wrong_words_are_bad_input() {
    let folder = Folder::new();
    let text = folder.cvr(&["stability", "--list"]).exits(0).stdout;
    for subject in Subject::all() {
        assert!(text.contains(&format!("{}  {}", subject.name, subject.doc)), "{text}");
    }
    assert!(text.contains("noise-floor") && text.contains("s3dc block=4 index_bits=2"), "{text}");
    let wrong = [
        (&["stability", "s3bc"][..], "no codec `s3bc`"),
        (&["stability", "--edge", "49"], "`edge = 49`: expected a number from 12 to 48"),
        (&["stability", "--config", "missing.toml"], "missing.toml"),
    ];
    for (words, expected) in wrong {
        let ran = folder.cvr(words).exits(2);
        assert!(ran.stderr.contains(expected), "{}", ran.stderr);
    }
    assert_eq!(folder.names(), [""; 0]);
}
