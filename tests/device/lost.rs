//! A device that is lost during a run costs the running cell, and no other.

use std::cell::{Cell, RefCell};
use std::path::Path;
use std::sync::atomic::AtomicBool;

use cvr::experiment::files::folder::OutFolder;
use cvr::experiment::identity::experiment;
use cvr::experiment::inputs::volumes::load;
use cvr::experiment::records::provenance::Provenance;
use cvr::experiment::records::record::Status;
use cvr::experiment::running::outcome::Outcome;
use cvr::experiment::running::run::Run;
use cvr::registry::Names;
use cvr::site::target::Target;
use cvr_core::pipeline::{Capabilities, Document, resolve};
use cvr_engine::testing::{another_device, lose, test_device};

/// Two volumes of four cells each.
const CONFIG: &str = r##"
[experiment]
name = "lost"
[[volume]]
name = "a"
generate = "shepp-logan"
dims = [9, 8, 7]
[[volume]]
name = "b"
generate = "turbulence"
dims = [9, 8, 7]
[[codec]]
id = "raw"
[[codec]]
id = "s3dc"
block = 4
index_bits = 2
[pipeline]
renderer = "raycasting"
site = ["inline", "host"]
filter = "linear"
[[scene]]
name = "s"
size = [24, 24]
transfer_function_domain = "range"
transfer_function = [[0.0, "#00000000"], [1.0, "#ffffffff"]]
"##;

/// What happens to a lost device.
#[derive(Copy, Clone, PartialEq)]
enum Then {
    Back,
    Gone,
    OnlyTheMirror,
}

/// Runs the experiment, and loses the device whenever `loses` holds for the cell that begins. Also returns how often it
/// was reopened.
fn run(folder: &Path, loses: impl Fn(&str) -> bool, then: Then) -> (Outcome, usize) {
    let names = Names::new().unwrap();
    let experiment = Document::parse("lost.toml", CONFIG).unwrap().experiment(&names.known()).unwrap();
    let resolution = resolve(&experiment, &names.known(), &Capabilities::default());
    let volumes: Vec<_> = experiment.volumes.iter().map(|v| load(v, experiment.seed).unwrap()).collect();
    let first = Target::Device(another_device());
    let current = RefCell::new(first.clone());
    let opened = Cell::new(0);
    let provenance = Provenance::default();
    let out = OutFolder::adopt(folder, experiment::owner(&provenance)).unwrap();
    let run = Run {
        experiment: &experiment,
        resolution: &resolution,
        volumes: &volumes,
        names: &names,
        target: &first,
        reopen: &|| {
            opened.set(opened.get() + 1);
            match then {
                Then::Gone => return Err("it is unplugged".to_owned()),
                Then::OnlyTheMirror => return Ok(Target::Cpu { reason: None }),
                Then::Back => {}
            }
            let fresh = Target::Device(another_device());
            *current.borrow_mut() = fresh.clone();
            Ok(fresh)
        },
        out: &out,
        stop: &AtomicBool::new(false),
        report: &|_, name| {
            if let Target::Device(device) = &*current.borrow()
                && loses(name)
            {
                lose(device);
            }
        },
    };
    let outcome = run.run(provenance).unwrap();
    (outcome, opened.get())
}

fn failed(outcome: &Outcome) -> Vec<(usize, &str)> {
    let records = outcome.records.iter().enumerate();
    let failed = records.filter(|(_, r)| r.status == Status::Failed);
    failed.map(|(i, r)| (i, r.error.as_deref().unwrap())).collect()
}

#[test]
fn without_a_loss_nothing_is_opened_anew() {
    if test_device("lost::none").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (outcome, opened) = run(folder.path(), |_| false, Then::Back);
    assert_eq!((outcome.records.len(), failed(&outcome), opened), (8, vec![], 0));
}

#[test]
fn a_lost_device_costs_one_cell_and_is_opened_anew() {
    if test_device("lost::anew").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let host = |name: &str| name.contains("a-raw") && name.contains("host");
    let (outcome, opened) = run(folder.path(), host, Then::Back);
    let failed = failed(&outcome);
    assert_eq!((outcome.records.len(), failed.len(), opened), (8, 1, 1), "{failed:?}");
    assert_eq!(failed[0].0, 1, "raw at host is the second cell");
    assert!(failed[0].1.contains("the device was lost"), "{failed:?}");
    assert_eq!(outcome.provenance.references.len(), 2);
}

#[test]
fn a_device_that_stays_away_fails_the_cells_that_are_left_with_the_reason() {
    if test_device("lost::for_good").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let host = |name: &str| name.contains("a-raw") && name.contains("host");
    let (outcome, opened) = run(folder.path(), host, Then::Gone);
    let failed = failed(&outcome);
    assert_eq!((outcome.records.len(), failed.len(), opened), (8, 7, 1), "{failed:?}");
    assert_eq!(outcome.records[0].status, Status::Ok, "what was finished before stays");
    for (_, reason) in &failed[1..] {
        assert!(reason.contains("the device was lost") && reason.contains("it is unplugged"), "{reason}");
    }
    let files = std::fs::read_dir(folder.path().join("cells")).unwrap().count();
    assert_eq!(files, 8, "each is recorded");
}

#[test]
fn another_device_does_not_take_its_place() {
    if test_device("lost::other").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (outcome, _) = run(folder.path(), |name| name.contains("b-s3dc"), Then::OnlyTheMirror);
    let failed = failed(&outcome);
    assert!(failed.len() == 2 && failed[1].1.contains("there is only cpu"), "{failed:?}");
    assert!(outcome.records.iter().all(|r| r.device != "cpu"));
}

#[test]
fn a_device_that_every_cell_loses_does_not_go_on_for_ever() {
    if test_device("lost::always").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (outcome, opened) = run(folder.path(), |_| true, Then::Back);
    assert_eq!((outcome.records.len(), outcome.failed()), (8, 8));
    assert!(opened <= 8, "{opened}");
}
