//! Folders of results: which files may be removed. No other file is ever removed.

use std::collections::BTreeMap;

use super::folder::Folder;

const CONFIG: &str = r##"
[experiment]
name = "own"
[[volume]]
name = "v"
generate = "shepp-logan"
dims = [6, 6, 6]
[[codec]]
id = "raw"
[pipeline]
renderer = "raycasting"
site = ["inline", "host"]
filter = "linear"
[[scene]]
name = "s"
size = [8, 8]
transfer_function = [[0, "#00000000"], [255, "#ffffffff"]]
"##;

const RUN: [&str; 4] = ["run", "x.toml", "--device", "cpu"];

fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("x.toml", CONFIG);
    folder
}

/// The name of the cell at the site *host*.
fn host_cell(folder: &Folder) -> String {
    let listed = folder.cvr(&["run", "x.toml", "--list-cells"]).exits(0).stdout;
    listed.lines().find(|line| line.contains("-host-")).unwrap().to_owned()
}

/// Every file with its bytes.
fn contents(folder: &Folder) -> BTreeMap<String, Vec<u8>> {
    folder
        .names()
        .into_iter()
        .filter(|n| folder.path(n).is_file())
        .map(|n| (n.clone(), folder.read(&n)))
        .collect()
}

fn litter(folder: &Folder, out: &str) {
    for name in ["images/fig1.png", "charts/mine.svg", "cells/mine.json", "thesis.tex", ".tmpAb12cD"] {
        let path = folder.path(&format!("{out}/{name}"));
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, name).unwrap();
    }
}

#[test]
fn a_folder_of_others_is_refused_and_written_to_beside_on_request() {
    let folder = prepared();
    folder.cvr(&[&RUN[..], &["--out", "part"]].concat()).exits(0);
    let stability = ["stability", "raw", "--quick", "--edge", "12", "--picture", "16", "--output", "out"];
    for command in
        [&[&RUN[..], &["--out", "out"]].concat()[..], &["merge", "part", "--out", "out"], &stability]
    {
        let _ = std::fs::remove_dir_all(folder.path("out"));
        litter(&folder, "out");
        let before = contents(&folder);
        let message = folder.cvr(command).refused();
        assert!(message.contains("holds files that cvr has not written there"), "{message}");
        assert!(message.contains("--overwrite") && message.contains("--out"), "{message}");
        assert_eq!(contents(&folder), before, "{command:?}");
        // Once next to them, and again over that result.
        folder.cvr(&[command, &["--overwrite"]].concat()).exits(0);
        folder.cvr(command).exits(0);
        let after = contents(&folder);
        assert!(after.len() > before.len() + 3);
        assert!(before.iter().all(|(name, bytes)| after.get(name) == Some(bytes)), "{command:?}");
        // Results are not written over a file of somebody else.
        let own = command[0] == "stability";
        let name = if own { "out/atlas.csv" } else { "out/results.csv" };
        std::fs::remove_dir_all(folder.path("out")).unwrap();
        litter(&folder, "out");
        folder.write(name, "mine");
        let before = contents(&folder);
        let message = folder.cvr(&[command, &["--overwrite"]].concat()).refused();
        assert!(message.contains(&format!("{name}: is there already")), "{message}");
        let mut after = contents(&folder);
        after.remove("out/cvr-files.jsonl");
        assert_eq!(after, before, "{command:?}");
    }
}

#[test]
fn the_working_folder_is_safe() {
    let folder = prepared();
    folder.write("report.txt", "mine");
    let before = contents(&folder);
    let here = [&RUN[..], &["--out", "."]].concat();
    assert!(folder.cvr(&here).refused().contains("(report.txt, x.toml)"));
    assert_eq!(contents(&folder), before);
    folder.cvr(&[&here[..], &["--overwrite"]].concat()).exits(0);
    folder.cvr(&[&here[..], &["--overwrite"]].concat()).exits(0);
    let after = contents(&folder);
    assert!(before.iter().all(|(name, bytes)| after.get(name) == Some(bytes)));
    assert!(after.contains_key("report.html"));
}

#[test]
fn the_same_experiment_is_replaced_and_says_so() {
    let folder = prepared();
    let first = folder.cvr(&RUN).exits(0);
    assert!(!first.stderr.contains("replaced"), "{}", first.stderr);
    let second = folder.cvr(&RUN).exits(0);
    let said = "results/own: the results of an earlier run of experiment `own` (2 cell(s)) are replaced";
    assert!(second.stderr.starts_with(said), "{}", second.stderr);
    // Comments and the order of keys do not change an experiment. A key does, and so do cells that would be lost.
    let commented = CONFIG.replace("name = \"own\"", "# a remark\nname = 'own'");
    folder.write("x.toml", &commented);
    assert!(folder.cvr(&RUN).exits(0).stderr.starts_with(said));
    let before = contents(&folder);
    let shard = folder.cvr(&[&RUN[..], &["--cell", &host_cell(&folder)]].concat());
    assert!(shard.refused().contains("1 of them would not be measured anew"));
    folder.write("x.toml", CONFIG.replace("[8, 8]", "[8, 9]"));
    let message = folder.cvr(&RUN).refused();
    assert!(message.contains("results/own: holds 2 cell(s) of experiment `own`"), "{message}");
    assert!(message.contains("its configuration is not that of this run"), "{message}");
    folder.write("x.toml", &commented);
    assert_eq!(contents(&folder), before);
    let both = folder.cvr(&[&RUN[..], &["--resume", "--overwrite"]].concat());
    assert_eq!(both.code, Some(2));
}

/// As version 0.1.0 left it: no list, no digests. Files that it names are ours, and so is the next picture.
#[test]
fn a_folder_of_the_first_version_is_known_by_what_it_names() {
    let folder = prepared();
    let first_version = || {
        let _ = std::fs::remove_dir_all(folder.path("results"));
        folder.cvr(&RUN).exits(0);
        std::fs::remove_file(folder.path("results/own/cvr-files.jsonl")).unwrap();
        for name in folder.names().iter().filter(|n| n.contains("/cells/")) {
            folder.write(name, folder.text(name).replace("\"digest\"", "\"another\""));
        }
        let ours = contents(&folder);
        litter(&folder, "results/own");
        ours
    };
    let ours = first_version();
    let foreign: BTreeMap<_, _> =
        contents(&folder).into_iter().filter(|(name, _)| !ours.contains_key(name)).collect();
    assert_eq!(foreign.len(), 5);
    let stays = || {
        let now = contents(&folder);
        assert!(foreign.iter().all(|(name, bytes)| now.get(name) == Some(bytes)));
    };
    // Another experiment: refused, or replaced on request.
    let other = [&RUN[..], &["--set", "scene.size=[9, 9]"]].concat();
    assert!(folder.cvr(&other).refused().contains("it ran with --set"));
    folder.cvr(&[&other[..], &["--overwrite"]].concat()).exits(0);
    stays();
    // The same.
    first_version();
    let ran = folder.cvr(&RUN).exits(0);
    assert!(ran.stderr.contains("(2 cell(s)) are replaced"), "{}", ran.stderr);
    stays();
    assert!(ours.keys().all(|name| folder.path(name).is_file()));
    // Resumed: all cells are run again, over the old files. One cell was not listed when that version was killed.
    first_version();
    let cell = host_cell(&folder);
    std::fs::remove_file(folder.path(&format!("results/own/cells/{cell}.json"))).unwrap();
    let mut results = folder.json("results/own/results.json");
    results["records"].as_array_mut().unwrap().retain(|r| r["site"] == "inline");
    folder.write("results/own/results.json", results.to_string());
    let ran = folder.cvr(&[&RUN[..], &["--resume"]].concat()).exits(0);
    assert!(ran.stdout.contains("0 of 2 cells taken over"), "{}", ran.stdout);
    assert!(ran.stderr.contains("1 cell(s) are run again: their records carry no digest"), "{}", ran.stderr);
    stays();
}

#[test]
fn a_comparison_does_not_take_the_place_of_results() {
    let folder = prepared();
    folder.cvr(&[&RUN[..], &["--out", "a"]].concat()).exits(0);
    folder.cvr(&[&RUN[..], &["--out", "b"]].concat()).exits(0);
    folder.write("change.csv", "of yesterday");
    let before = contents(&folder);
    for (option, name) in
        [("--html", "b/report.html"), ("--csv", "b/results.csv"), ("--csv", "a/charts/../results.csv")]
    {
        let message = folder.cvr(&["compare", "a", "b", option, name]).refused();
        assert!(message.contains("is one of the results of its folder"), "{message}");
    }
    assert_eq!(contents(&folder), before);
    folder.cvr(&["compare", "a", "b", "--csv", "change.csv", "--html", "b/change.html"]).exits(0);
    assert_ne!(folder.text("change.csv"), "of yesterday");
    folder.cvr(&[&RUN[..], &["--out", "b"]].concat()).exits(0);
    assert!(folder.path("b/change.html").is_file(), "it is no result of that run");
}
