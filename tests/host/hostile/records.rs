//! Tampered results and records: no report, comparison or merge panics, and a record is taken over only if it is
//! unchanged.

use std::path::Path;

use cvr::compare;
use cvr::experiment::files::cell_file::CellFile;
use cvr::experiment::files::folder::OutFolder;
use cvr::experiment::files::results::Results;
use cvr::experiment::identity::experiment;
use cvr::experiment::records::record::Record;
use cvr::experiment::shards::merge::{Source, merge};
use cvr::report;
use serde_json::Value;

use super::super::folder::Folder;
use super::mutate::{self, Dice, campaign};

const CONFIG: &str = r##"
[experiment]
name = "tiny"
seed = 1
[[volume]]
name = "v"
generate = "shepp-logan"
dims = [6, 6, 6]
[[codec]]
id = "raw"
[[codec]]
id = "s3dc"
block = 4
[pipeline]
renderer = "raycasting"
site = ["inline", "host"]
filter = "linear"
[[scene]]
name = "front"
size = [12, 12]
transfer_function = [[0.0, "#00000000"], [255.0, "#ffffffff"]]
"##;

/// A folder with a run's results in `a`.
fn run() -> Folder {
    let folder = Folder::new();
    folder.write("tiny.toml", CONFIG);
    folder.cvr(&["run", "tiny.toml", "--device", "cpu", "--out", "a"]).exits(0);
    folder
}

/// A JSON file with edits of values or bytes.
fn edited(dice: &mut Dice, whole: &[u8]) -> Vec<u8> {
    if dice.below(4) == 0 {
        let mut file = whole.to_vec();
        mutate::bytes(dice, &mut file, whole);
        return file;
    }
    let mut value: Value = serde_json::from_slice(whole).unwrap();
    for _ in 0..=dice.below(3) {
        mutate::json(dice, &mut value);
    }
    serde_json::to_vec(&value).unwrap()
}

#[test]
fn no_results_make_report_or_comparison_panic() {
    let folder = run();
    let whole = folder.read("a/results.json");
    let (good, bad) = (folder.path("a/results.json"), folder.path("bad.json"));
    let out = folder.path("report");
    campaign("results", 250, |mut dice: Dice| -> Result<bool, String> {
        std::fs::write(&bad, edited(&mut dice, &whole)).unwrap();
        let _ = std::fs::remove_dir_all(&out);
        std::fs::create_dir(&out).unwrap();
        let Ok(results) = Results::read(&bad) else { return Ok(false) };
        let Results { provenance, records, refused } = &results;
        let folder = OutFolder::adopt(&out, experiment::owner(provenance))?;
        report::write(&folder, provenance, records, refused).map_err(|e| format!("report: {e}"))?;
        let Ok(sides) = compare::read(&[good.clone(), bad.clone()]) else { return Ok(false) };
        compare::csv(&sides, 0.1).map_err(|e| format!("compare: {e}"))?;
        compare::page(&sides, 0.1).map_err(|e| format!("compare: {e}"))?;
        Ok(!compare::text(&sides, 0.1).is_empty())
    });
}

#[test]
fn no_record_makes_merging_panic() {
    let folder = run();
    let cells: Vec<String> = folder.names().into_iter().filter(|name| name.starts_with("a/cells/")).collect();
    let whole: Vec<Vec<u8>> = cells.iter().map(|name| folder.read(name)).collect();
    let results = folder.read("a/results.json");
    let (a, out) = (folder.path("a"), folder.path("merged"));
    campaign("records", 400, |mut dice: Dice| -> Result<bool, String> {
        for (name, whole) in cells.iter().zip(&whole) {
            let bytes = if dice.below(2) == 0 { edited(&mut dice, whole) } else { whole.clone() };
            folder.write(name, bytes);
        }
        folder.write(
            "a/results.json",
            if dice.below(3) == 0 { edited(&mut dice, &results) } else { results.clone() },
        );
        taken_over(&a, &cells, &whole)?;
        let _ = std::fs::remove_dir_all(&out);
        let Ok(merged) = Source::read(&a).and_then(|source| merge(vec![source], &[])) else {
            return Ok(false);
        };
        let folder = OutFolder::adopt(&out, experiment::owner(&merged.provenance()))?;
        Ok(merged.write(&folder).is_ok())
    });
}

/// Records as resuming takes them over, from their own file and with their key: each is unchanged.
fn taken_over(a: &Path, cells: &[String], whole: &[Vec<u8>]) -> Result<(), String> {
    for (name, whole) in cells.iter().zip(whole) {
        let stem = Path::new(name).file_stem().unwrap().to_str().unwrap();
        let original = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(original.path(), whole).unwrap();
        let written = CellFile::<Record>::read(original.path()).unwrap();
        let Ok(taken) = CellFile::<Record>::whole(a, stem, written.key.as_deref().unwrap(), |_| true) else {
            continue;
        };
        if taken != written {
            return Err(format!("{stem}: an edited record is taken over"));
        }
    }
    Ok(())
}
