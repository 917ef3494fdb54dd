//! The notes of `cvr render`: those that a run would record.

use std::path::PathBuf;

use super::super::folder::Folder;
use super::super::volumes::{computed, floats};
use cvr::input::Generator;
use cvr_core::volume::SampleType;

const CONFIG: &str = r##"
[experiment]
name = "holes"
[[volume]]
name = "v"
file = "v.nrrd"
[[codec]]
id = "raw"
[pipeline]
renderer = "raycasting"
site = ["inline", "host"]
filter = "linear"
[[scene]]
name = "s"
size = [8, 8]
transfer_function_domain = "range"
transfer_function = [[0.0, "#00000000"], [1.0, "#ffffffff"]]
"##;

fn notes(stderr: &str) -> Vec<&str> {
    stderr.lines().filter_map(|line| line.strip_prefix("note: ")).collect()
}

const REPLACED: &str = "3 of 60 samples are no usable numbers and were replaced: 1 NaN as the lowest finite value, 2 infinite \
                        as the highest or lowest finite value";

fn with_holes() -> Folder {
    let folder = Folder::new();
    let value = |[x, y, z]: [u32; 3]| match (x, y, z) {
        (0, 0, 0) => f32::NAN,
        (1, 2, 1) => f32::INFINITY,
        (3, 1, 2) => f32::NEG_INFINITY,
        _ => (x + y * z) as f32,
    };
    folder.volume("v.nrrd", &floats([5, 4, 3], value));
    folder
}

#[test]
fn replaced_samples_and_the_shader_that_did_not_run_are_told() {
    let folder = with_holes();
    let drawn = folder.cvr(&["render", "v.nrrd", "p.png", "--size", "16x16", "--device", "cpu"]).exits(0);
    let told = notes(&drawn.stderr);
    assert_eq!((told.len(), told[0]), (2, REPLACED), "{told:?}");
    assert!(told[1].starts_with("shader not run: the CPU mirror drew"), "{told:?}");
    // A container stores the numbers of replaced samples.
    folder.cvr(&["encode", "v.nrrd", "v.cvr", "--codec", "raw"]).exits(0);
    let host = ["render", "v.cvr", "p.png", "--size", "16x16", "--device", "cpu", "--site", "host"];
    assert_eq!(notes(&folder.cvr(&host).exits(0).stderr), [REPLACED]);
}

#[test]
fn a_run_notes_the_same() {
    let folder = with_holes();
    folder.write("c.toml", CONFIG);
    let ran = folder.cvr(&["run", "c.toml", "--device", "cpu"]).exits(0);
    assert!(ran.stderr.contains("shader not run: 1 of 2 cells"), "{}", ran.stderr);
    let results = folder.json("results/holes/results.json");
    for record in results["records"].as_array().unwrap() {
        let notes = record["notes"].as_str().unwrap();
        assert!(notes.starts_with(REPLACED), "{notes}");
        assert_eq!(notes.contains("shader not run"), record["site"] == "inline", "{notes}");
    }
    let report = folder.text("results/holes/report.html");
    assert!(report.contains("Shader not run: 1 of 2 cells") && report.contains(">shader not run<"));
}

#[test]
fn a_volume_of_usable_numbers_has_no_note_of_it() {
    let folder = Folder::new();
    folder.volume("v.nrrd", &computed(Generator::Turbulence, [5, 6, 7], SampleType::U8));
    let host =
        ["render", "v.nrrd", "p.png", "--size", "16x16", "--device", "cpu", "--site", "host", "--no-check"];
    let drawn = folder.cvr(&host).exits(0);
    assert_eq!(drawn.stderr, "");
}

/// Volumes of a public bug report: half NaN, two infinities, all NaN.
#[test]
fn volumes_with_nan_are_drawn_with_a_note() {
    let cases =
        std::env::var_os("CVR_DATA").map(|data| PathBuf::from(data).join("../cases/scenes/29-nan-volume"));
    let Some(cases) = cases.filter(|cases| cases.is_dir()) else {
        println!("skipped cli::render: CVR_DATA names no folder beside `cases`");
        return;
    };
    let folder = Folder::new();
    for (name, told) in [
        ("inf.npy", Some("2 of 13824 samples are no usable numbers and were replaced: 2 infinite as the ")),
        ("allnan.npy", Some(" NaN, 0 infinite): all stand as 0")),
        ("nan.npy", Some(" NaN as the lowest finite value")),
        ("zero.npy", None),
    ] {
        let file = cases.join(name);
        let arguments = ["render", file.to_str().unwrap(), "p.png", "--size", "16x16", "--device", "cpu"];
        let drawn = folder.cvr(&arguments).exits(0);
        let notes = notes(&drawn.stderr);
        let replaced = notes.iter().find(|note| note.contains("samples"));
        assert_eq!(replaced.is_some(), told.is_some(), "{name}: {notes:?}");
        assert!(told.is_none_or(|told| replaced.unwrap().contains(told)), "{name}: {notes:?}");
    }
}
