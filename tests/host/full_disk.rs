//! Full disks, simulated by a limit on file sizes: no incomplete file has a final name, and failures are reported.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::process::Command;

use cvr::experiment::files::results::Results;
use cvr::input::Generator;
use cvr_core::volume::SampleType;

use super::folder::{Folder, Ran};
use super::kills::damage;
use super::volumes::seeded;

/// Runs the program with files of at most this many blocks of 512 bytes. The signal that would end it is ignored, so
/// that writing fails as on a full disk.
fn limited(folder: &Folder, blocks: u32, args: &[&str]) -> Ran {
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f \"$1\"; shift; exec \"$@\"", "sh", &blocks.to_string()])
        .arg(env!("CARGO_BIN_EXE_cvr"))
        .args(args)
        .current_dir(folder.root())
        .env_remove("CVR_DATA")
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Ran { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

const CONFIG: &str = r##"
[experiment]
name = "full"
[[volume]]
name = "v"
generate = "turbulence"
dims = [12, 12, 12]
[[codec]]
id = "raw"
[[codec]]
id = "s3dc"
[pipeline]
renderer = "raycasting"
site = "host"
filter = "linear"
[[scene]]
name = "s"
size = [48, 48]
transfer_function = [[60, "#00000000"], [140, "#d08040c0"], [255, "#ffffffff"]]
"##;

#[test]
fn each_kind_of_file_is_whole_or_not_there() {
    let folder = Folder::new();
    folder.volume("v.nrrd", &seeded(Generator::Turbulence, [16, 16, 16], SampleType::U8, 3));
    folder.cvr(&["encode", "v.nrrd", "v.cvr", "--codec", "raw"]).exits(0);
    folder.write("x.toml", CONFIG);
    folder.cvr(&["run", "x.toml", "--device", "cpu", "--out", "a"]).exits(0);
    folder.volume("s.nrrd", &seeded(Generator::Turbulence, [4, 4, 4], SampleType::U8, 3));
    let picture = ["--device", "cpu", "--size", "128x128", "--transfer-function", "heat"];
    let before = folder.names();
    for (first, name, more) in [
        (&["encode", "v.nrrd"][..], "x.cvr", &["--codec", "raw"][..]),
        (&["decode", "v.cvr"], "x.nrrd", &[]),
        (&["convert", "v.nrrd"], "x2.nrrd", &[]),
        (&["convert", "v.nrrd"], "x.npy", &[]),
        (&["convert", "v.nrrd"], "x.raw", &[]),
        (&["render", "s.nrrd"], "x.png", &picture),
        (&["schema", "--out"], "x.json", &[]),
        (&["compare", "a", "a", "--csv"], "x.csv", &[]),
        (&["compare", "a", "a", "--html"], "x.html", &[]),
    ] {
        let words = [first, &[name], more].concat();
        // `render` encodes before it draws, into a temporary file of some 2 KiB.
        for blocks in if name == "x.png" { [5, 6] } else { [0, 2] } {
            let message = limited(&folder, blocks, &words).refused();
            let named = message.contains(name) && message.contains("File too large");
            assert!(named, "{words:?} in {blocks} blocks: {message}");
            assert_eq!(folder.names(), before, "{words:?} in {blocks} blocks leaves something behind");
        }
        folder.cvr(&words).exits(0);
        let whole = folder.read(name);
        assert!(whole.len() > 1024, "{name}: {}", whole.len());
        // An older file stays. The largest limit that is too small is one block less.
        let blocks = whole.len().div_ceil(512) - 1;
        assert_eq!(limited(&folder, blocks as u32, &words).code, Some(2), "{words:?}");
        assert!(folder.read(name) == whole);
        limited(&folder, blocks as u32 + 1, &words).exits(0);
        std::fs::remove_file(folder.path(name)).unwrap();
    }
}

fn pictures(folder: &Folder, run: &str) -> Vec<(String, Vec<u8>)> {
    let images = format!("{run}/images/");
    let names = folder.names().into_iter().filter(|n| n.starts_with(&images));
    names.map(|n| (n.strip_prefix(&images).unwrap().to_owned(), folder.read(&n))).collect()
}

#[test]
fn a_run_leaves_nothing_torn_and_goes_on_from_what_is_whole() {
    let folder = Folder::new();
    folder.write("x.toml", CONFIG);
    let run = |out: &'static str| ["run", "x.toml", "--device", "cpu", "--out", out];
    folder.cvr(&run("whole")).exits(0);
    let results = Results::read(&folder.path("whole/results.json")).unwrap();
    let bytes =
        |n: &String| std::fs::metadata(folder.path(n)).map_or(0, |m| if m.is_file() { m.len() } else { 0 });
    let names = folder.names();
    let largest = names.iter().filter(|n| n.starts_with("whole/")).map(bytes).max();
    let largest = largest.unwrap().div_ceil(512) as u32;
    let mut kinds = BTreeSet::new();
    for blocks in [0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64].into_iter().filter(|b| *b < largest) {
        let _ = std::fs::remove_dir_all(folder.path("out"));
        let ran = limited(&folder, blocks, &run("out"));
        assert!(matches!(ran.code, Some(1 | 2)), "{blocks}: {ran:?}");
        assert!(
            ran.stderr.contains("out/") && ran.stderr.contains("File too large"),
            "{blocks}: {}",
            ran.stderr
        );
        for name in folder.names().iter().filter(|n| n.starts_with("out/") && folder.path(n).is_file()) {
            assert_eq!(damage(name, &folder.read(name)), None, "{blocks}: {name}");
            assert!(!name.contains(".cvr-"), "{blocks}: {name} is left over");
        }
        let named = |kind: &&str| ran.stderr.contains(&format!("{kind}: File too large"));
        kinds.extend([".jsonl", ".json", ".svg", ".csv", ".png", ".html"].into_iter().filter(named));
        let ran = folder.cvr(&[&run("out")[..], &["--resume"]].concat()).exits(0);
        assert!(ran.stdout.contains("2 cells: 2 ok, 0 failed"), "{}", ran.stdout);
        assert!(pictures(&folder, "out") == pictures(&folder, "whole"), "{blocks}");
        let again = Results::read(&folder.path("out/results.json")).unwrap();
        assert_eq!(again.records.len(), results.records.len());
    }
    // Pictures and charts are smaller than the files written before them.
    let expected = [".jsonl", ".json", ".html"];
    assert!(expected.iter().all(|kind| kinds.contains(kind)), "files that did not fit: {kinds:?}");
}

/// If the disk is full before the first new cell, the old results stay.
#[test]
fn results_of_before_outlast_a_run_that_cannot_write() {
    let folder = Folder::new();
    folder.write("x.toml", CONFIG);
    let run = ["run", "x.toml", "--device", "cpu", "--out", "out"];
    folder.cvr(&run).exits(0);
    let state = || -> Vec<_> {
        let files = folder.names().into_iter().filter(|n| folder.path(n).is_file());
        files.map(|n| (folder.read(&n), n)).collect()
    };
    let before = state();
    let ran = limited(&folder, 1, &run).exits(2);
    assert!(ran.stderr.contains("File too large"), "{}", ran.stderr);
    assert!(state() == before);
    folder.cvr(&run).exits(0);
    assert!(state() != before);
}
