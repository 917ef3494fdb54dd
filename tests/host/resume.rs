//! Resuming a run: which cells are taken over, and which are run again.

use std::time::SystemTime;

use cvr::experiment::files::cell_file::digest_of;
use cvr::experiment::files::folder::lock;
use cvr::experiment::files::results::Results;
use cvr::input::Generator;
use cvr_core::volume::SampleType;

use super::folder::{Folder, Ran};
use super::volumes::seeded;

/// Two volumes, two codecs, two sites, two scenes: 16 cells, 8 of each volume.
const CONFIG: &str = r##"
[experiment]
name = "tiny"
seed = 7
[[volume]]
name = "noise"
generate = "turbulence"
dims = [8, 8, 8]
[[volume]]
name = "scan"
file = "scan.nrrd"
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
name = "front"
size = [16, 16]
transfer_function = [[60, "#00000000"], [140, "#d08040c0"], [255, "#ffffffff"]]
[[scene]]
name = "top"
size = [16, 16]
camera = { elevation = 80.0 }
transfer_function = [[60, "#00000000"], [140, "#d08040c0"], [255, "#ffffffff"]]
"##;

const RESUME: [&str; 7] = ["run", "tiny.toml", "--device", "cpu", "--out", "out", "--resume"];

/// A folder in which the experiment has run.
fn finished() -> Folder {
    let folder = Folder::new();
    folder.write("tiny.toml", CONFIG);
    folder.volume("scan.nrrd", &seeded(Generator::Turbulence, [8, 6, 4], SampleType::U8, 3));
    folder.cvr(&RESUME[..6]).exits(0);
    folder
}

fn resume(folder: &Folder) -> Ran {
    folder.cvr(&RESUME).exits(0)
}

/// Cells that were taken over and volumes that were encoded.
fn counts(ran: &Ran) -> (usize, usize) {
    let line = ran.stdout.lines().find(|l| l.contains("cells taken over")).unwrap();
    let numbers: Vec<usize> =
        line.split(|c: char| !c.is_ascii_digit()).filter_map(|n| n.parse().ok()).collect();
    assert_eq!(numbers[1], 16, "{line}");
    (numbers[0], numbers[2])
}

fn cells(folder: &Folder) -> Vec<String> {
    folder.names().into_iter().filter(|n| n.starts_with("out/cells/")).collect()
}

/// The file of a cell, by parts of its name.
fn cell(folder: &Folder, parts: &[&str]) -> String {
    cells(folder).into_iter().find(|n| parts.iter().all(|p| n.contains(p))).unwrap()
}

type State = Vec<(String, Vec<u8>, SystemTime)>;

/// Every cell file and picture, with its bytes and modification time.
fn state(folder: &Folder) -> State {
    let names = folder.names().into_iter();
    let files = names.filter(|n| n.starts_with("out/cells/") || n.starts_with("out/images/"));
    files
        .map(|n| {
            let changed = std::fs::metadata(folder.path(&n)).unwrap().modified().unwrap();
            let bytes = folder.read(&n);
            (n, bytes, changed)
        })
        .collect()
}

/// Files that differ between two states.
fn changed(before: &State, after: &State) -> Vec<String> {
    after.iter().filter(|file| !before.contains(file)).map(|(name, ..)| name.clone()).collect()
}

#[test]
fn a_finished_run_is_taken_over_as_it_is() {
    let folder = finished();
    let (before, results) = (state(&folder), folder.json("out/results.json"));
    let csv = folder.text("out/results.csv");
    std::fs::remove_file(folder.path("out/report.html")).unwrap();
    assert_eq!(counts(&resume(&folder)), (16, 0), "nothing is run, not even the baseline is encoded");
    assert_eq!(changed(&before, &state(&folder)), [""; 0]);
    let again = folder.json("out/results.json");
    assert_eq!(again["records"], results["records"]);
    assert_eq!(again["provenance"]["references"], results["provenance"]["references"]);
    assert_eq!(results["provenance"]["references"].as_array().unwrap().len(), 4);
    assert_eq!(folder.text("out/results.csv"), csv, "infinite values too");
    assert!(folder.path("out/report.html").is_file());
}

#[test]
fn only_what_is_missing_is_run_and_encoded() {
    let folder = finished();
    let results = Results::read(&folder.path("out/results.json")).unwrap();
    let lost = cell(&folder, &["noise", "s3dc", "front", "host"]);
    std::fs::remove_file(folder.path(&lost)).unwrap();
    let before = state(&folder);
    // The baseline of one volume, and one codec.
    assert_eq!(counts(&resume(&folder)), (15, 2));
    let changed = changed(&before, &state(&folder));
    assert_eq!(changed.len(), 3, "its file and its pictures: {changed:?}");
    assert!(changed.iter().all(|n| n.contains("noise-s3dc-block=4,index_bits=2-front-raycasting-host")));

    let again = Results::read(&folder.path("out/results.json")).unwrap();
    let identity = |r: &cvr::experiment::records::record::Record| {
        format!("{} {} {} {}", r.volume, r.codec, r.scene, r.site)
    };
    let order = |r: &Results| r.records.iter().map(identity).collect::<Vec<_>>();
    assert_eq!(order(&again), order(&results), "in the order of the cells");
    let same = again.records.iter().zip(&results.records).filter(|(a, b)| a == b).count();
    assert_eq!(same, 15, "one was measured anew");
}

#[test]
fn without_resume_everything_is_run() {
    let folder = finished();
    let before = state(&folder);
    folder.cvr(&RESUME[..6]).exits(0);
    assert_eq!(changed(&before, &state(&folder)).len(), before.len());
}

#[test]
fn what_goes_into_a_result_decides() {
    let folder = finished();
    let count = |set: &[&str]| counts(&folder.cvr(&[&RESUME[..], set].concat()).exits(0)).0;
    // Nothing is taken over under another seed: anything random may depend on it.
    assert_eq!(count(&["--set", "experiment.seed=8"]), 0);
    assert_eq!(count(&[]), 0, "and back again");
    assert_eq!(count(&[]), 16);
    assert_eq!(count(&["--set", "scene.front.step_voxels=0.7"]), 8, "the other scene is as it was");
    assert_eq!(count(&[]), 8);
    assert_eq!(count(&["--set", "codec.s3dc.index_bits=4"]), 8, "raw is as it was");
    // Another name is another file: the old cells are still there.
    assert_eq!(count(&[]), 16);
    assert_eq!(count(&["--set", "experiment.name=other"]), 16, "a name is no input");
}

#[test]
fn another_content_of_a_volume_is_another_result() {
    let folder = finished();
    folder.volume("scan.nrrd", &seeded(Generator::Turbulence, [8, 6, 4], SampleType::U8, 4));
    assert_eq!(counts(&resume(&folder)), (8, 3), "of one volume only: baseline and two codecs");
    assert_eq!(counts(&resume(&folder)), (16, 0));
    // The same samples in another shape.
    let samples = seeded(Generator::Turbulence, [8, 6, 4], SampleType::U8, 4);
    folder.write("scan.raw", samples.samples().as_bytes());
    let shaped = CONFIG.replace("\"scan.nrrd\"", "\"scan.raw\"\ndims = [6, 8, 4]\ndtype = \"u8\"");
    folder.write("tiny.toml", &shaped);
    assert_eq!(counts(&resume(&folder)).0, 8);
    folder.write("tiny.toml", shaped.replace("dtype", "spacing = [1.0, 2.0, 1.0]\ndtype"));
    assert_eq!(counts(&resume(&folder)).0, 8);
}

#[test]
fn a_file_that_is_no_whole_record_is_run_again() {
    let folder = finished();
    let name = cell(&folder, &["scan", "raw", "top", "inline"]);
    let whole = folder.text(&name);
    let key = folder.json(&name)["key"].as_str().unwrap().to_owned();
    for (what, text) in [
        ("truncated", whole[..whole.len() / 2].to_owned()),
        ("empty", String::new()),
        ("garbage", "\0\u{1}not json".to_owned()),
        ("another key", whole.replace(&key, &key.chars().rev().collect::<String>())),
        ("no key", whole.replace("\"key\"", "\"lock\"")),
        ("no digest", whole.replace("\"digest\"", "\"another\"")),
        ("a figure", whole.replacen("\"psnr_db\": ", "\"psnr_db\": 1", 1)),
        ("a figure, and its digest as it was", whole.replacen("\"frame_pairs\": ", "\"frame_pairs\": 1", 1)),
        ("another cell", folder.text(&cell(&folder, &["scan", "raw", "top", "host"]))),
        ("failed", whole.replace("\"status\": \"ok\"", "\"status\": \"failed\"")),
        ("foreign picture", whole.replace("\"image\": \"images/", "\"image\": \"images/../images/")),
    ] {
        assert_ne!(text, whole, "{what}");
        folder.write(&name, text);
        assert_eq!(counts(&resume(&folder)), (15, 2), "{what}");
        assert_eq!(counts(&resume(&folder)), (16, 0), "{what}: whole again");
    }
}

/// A forged record with a valid digest: if its names or key are not the cell's, it is not taken over.
#[test]
fn a_sealed_record_of_another_cell_is_run_again() {
    let folder = finished();
    let name = cell(&folder, &["scan", "raw", "top", "inline"]);
    let whole = folder.read(&name);
    let sealed = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut value: serde_json::Value = serde_json::from_slice(&whole).unwrap();
        value.as_object_mut().unwrap().remove("digest").unwrap();
        change(&mut value);
        value["digest"] = digest_of(&value).into();
        folder.write(&name, serde_json::to_vec_pretty(&value).unwrap());
        resume(&folder)
    };
    assert_eq!(counts(&sealed(&|_| {})), (16, 0), "the twin: sealed as it was");
    for (field, other) in [
        ("volume", "noise"),
        ("codec", "s3dc"),
        ("settings", "bits=8"),
        ("site", "host"),
        ("filter", "nearest"),
        ("renderer", "slicing"),
        ("scene", "front"),
        ("device", "gpu"),
        ("driver", "1.2"),
    ] {
        let ran = sealed(&|value| value[field] = other.into());
        assert_eq!(counts(&ran), (15, 2), "{field}");
        assert!(
            ran.stderr.contains("1 cell(s) are run again: their records are of other cells (cells/scan-raw"),
            "{}",
            ran.stderr
        );
    }
    for (field, other) in [("skipping", true.into()), ("stages", 2.into()), ("frames", 7.into())] {
        let ran = sealed(&|value| value[field] = serde_json::Value::clone(&other));
        assert_eq!(counts(&ran), (15, 2), "{field}");
    }
}

/// As version 0.1.0 wrote them: all cells are run again, with one message.
#[test]
fn records_without_a_digest_are_run_again() {
    let folder = finished();
    for name in cells(&folder) {
        folder.write(&name, folder.text(&name).replace("\"digest\"", "\"another\""));
    }
    let ran = resume(&folder);
    assert_eq!(counts(&ran), (0, 6));
    let said = "16 cell(s) are run again: their records carry no digest, as those of version 0.1.0 (cells/";
    assert!(ran.stderr.contains(said) && ran.stderr.contains(" and 15 more)"), "{}", ran.stderr);
    let again = resume(&folder);
    assert_eq!(counts(&again), (16, 0));
    assert!(!again.stderr.contains("run again"), "{}", again.stderr);
}

#[test]
fn a_cell_needs_its_pictures() {
    let folder = finished();
    let json = folder.json(&cell(&folder, &["scan", "s3dc", "top", "inline"]));
    for column in ["image", "error_image"] {
        let name = format!("out/{}", json[column].as_str().unwrap());
        let bytes = folder.read(&name);
        std::fs::remove_file(folder.path(&name)).unwrap();
        assert_eq!(counts(&resume(&folder)), (15, 2), "{name} is missing");
        folder.write(&name, &bytes[..bytes.len() - 1]);
        assert_eq!(counts(&resume(&folder)), (15, 2), "{name} is cut short");
        assert_eq!(folder.read(&name), bytes, "the mirror draws the same again");
    }
    assert_eq!(counts(&resume(&folder)), (16, 0));
}

#[test]
fn a_missing_reference_is_drawn_and_no_cell_is_run() {
    let folder = finished();
    let names = folder.names();
    let name = names.iter().find(|n| n.contains("images/reference-scan-top")).unwrap();
    let bytes = folder.read(name);
    let before = state(&folder);
    for damage in [None, Some(&bytes[..9])] {
        match damage {
            None => std::fs::remove_file(folder.path(name)).unwrap(),
            Some(bytes) => folder.write(name, bytes),
        }
        assert_eq!(counts(&resume(&folder)), (16, 1), "the baseline of its volume is encoded");
        assert_eq!(folder.read(name), bytes);
        assert_eq!(changed(&before, &state(&folder)), [name.as_str()]);
        let references = folder.json("out/results.json")["provenance"]["references"].clone();
        assert_eq!(references.as_array().unwrap().len(), 4);
    }
}

#[test]
fn more_cells_join_those_that_are_there() {
    let folder = finished();
    folder.write("tiny.toml", CONFIG.replace("index_bits = 2", "index_bits = [2, 4]"));
    let ran = resume_of_24(&folder);
    assert!(ran.contains("16 of 24 cells taken over; 4 encodings"), "{ran}");
    assert_eq!(folder.json("out/results.json")["records"].as_array().unwrap().len(), 24);
}

fn resume_of_24(folder: &Folder) -> String {
    folder.cvr(&RESUME).exits(0).stdout
}

#[test]
fn failed_cells_are_run_again() {
    let folder = Folder::new();
    let loud: Vec<u8> = [65535_u16; 8].iter().flat_map(|v| v.to_le_bytes()).collect();
    folder.write("loud.raw", loud);
    let config = CONFIG
        .replace(
            "generate = \"turbulence\"\ndims = [8, 8, 8]",
            "file = \"loud.raw\"\ndims = [2, 2, 2]\ndtype = \"u16\"",
        )
        .replace("[[volume]]\nname = \"scan\"\nfile = \"scan.nrrd\"\n", "")
        .replace("id = \"raw\"", "id = \"raw\"\nbits = [\"native\", \"half\"]");
    folder.write("tiny.toml", config);
    folder.cvr(&RESUME[..6]).exits(1);
    let ran = folder.cvr(&RESUME).exits(1);
    assert!(ran.stdout.contains("8 of 12 cells taken over; 2 encodings"), "{}", ran.stdout);
    assert!(ran.stdout.contains("12 cells: 8 ok, 4 failed"), "{}", ran.stdout);
}

#[test]
fn a_folder_that_another_run_writes_to_is_refused() {
    let folder = finished();
    let before = state(&folder);
    let held = lock(&folder.path("out")).unwrap();
    for arguments in [&RESUME[..], &RESUME[..6]] {
        let message = folder.cvr(arguments).refused();
        assert!(message.contains("another run writes to this folder"), "{message}");
    }
    assert_eq!(changed(&before, &state(&folder)), [""; 0]);
    drop(held);
    assert_eq!(counts(&resume(&folder)), (16, 0));
}
