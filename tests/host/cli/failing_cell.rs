//! A run in which some cells fail: exit code 1, the reason in record and report, and all other cells unaffected.

use super::super::folder::Folder;

const CONFIG: &str = r##"
[experiment]
name = "half"
[[volume]]
name = "loud"
file = "loud.raw"
dims = [6, 5, 4]
dtype = "u16"
[[codec]]
id = "raw"
bits = ["native", "half"]
[pipeline]
renderer = "raycasting"
site = ["inline", "host"]
filter = "linear"
[[scene]]
name = "s"
size = [16, 16]
transfer_function_domain = "range"
transfer_function = [[0.0, "#00000000"], [1.0, "#ffffffff"]]
"##;

/// 65504 is the largest half.
fn folder(largest: u16) -> Folder {
    let folder = Folder::new();
    let samples: Vec<u8> = (0..120).flat_map(|i: u16| (largest - 500 * i).to_le_bytes()).collect();
    folder.write("loud.raw", samples);
    folder.write("half.toml", CONFIG);
    folder
}

#[test]
fn a_cell_that_fails_is_recorded_and_the_report_is_written() {
    let folder = folder(65535);
    let ran = folder.cvr(&["run", "half.toml", "--device", "cpu"]).exits(1);
    assert!(ran.stderr.contains("failed: loud raw bits=half inline linear s: "), "{}", ran.stderr);
    assert!(ran.stdout.contains("4 cells: 2 ok, 2 failed"), "{}", ran.stdout);
    let results = folder.json("results/half/results.json");
    let records = results["records"].as_array().unwrap();
    assert_eq!(records.len(), 4);
    for record in records {
        if record["settings"] == "bits=half" {
            assert_eq!(record["status"], "failed");
            let error = record["error"].as_str().unwrap();
            assert!(error.contains("65504"), "the reason is told: {error}");
            assert!(record["image"].is_null() && record["frame_ms"].is_null() && record["psnr_db"].is_null());
        } else {
            assert_eq!((record["status"].as_str(), record["error"].as_str()), (Some("ok"), None));
            assert!(record["image"].is_string());
        }
    }
    let report = folder.text("results/half/report.html");
    assert!(report.contains("65504"), "the report tells the reason");
    let names = folder.names();
    let pictures = names.iter().filter(|n| n.contains("/images/loud") && !n.ends_with(".error.png"));
    assert_eq!(pictures.count(), 2, "a cell that fails leaves no picture: {names:?}");
    assert_eq!(names.iter().filter(|n| n.contains("/cells/")).count(), 4, "but a record: {names:?}");
}

#[test]
fn without_the_one_value_too_large_nothing_fails() {
    let ran = folder(65504).cvr(&["run", "half.toml", "--device", "cpu"]).exits(0);
    assert!(ran.stdout.contains("4 cells: 4 ok, 0 failed"), "{}", ran.stdout);
}
