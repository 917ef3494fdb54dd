//! Levels of a codec with stages, from the configuration to the record.

use cvr::experiment::files::results::Results;
use cvr::experiment::identity::cell::of_record as identity;
use cvr::experiment::records::record::{Record, Status};

use super::folder::Folder;

const CONFIG: &str = r##"
[experiment]
name = "stages"
[[volume]]
name = "v"
generate = "turbulence"
dims = [21, 18, 13]
[[codec]]
id = "raw"
[[codec]]
id = "hvq"
coarse_codewords = 16
detail_codewords = 16
[pipeline]
renderer = "raycasting"
site = ["inline", "deferred", "host"]
filter = ["linear", "optimised-linear"]
skipping = [false, true]
stages = ["all", 1, 2, 3, 4]
[[scene]]
name = "front"
size = [24, 24]
transfer_function = [[0, "#00000000"], [90, "#ffffff00"], [150, "#ffb04060"], [255, "#ffffffff"]]
"##;

#[test]
fn every_level_is_decoded_drawn_and_measured_by_itself() {
    let folder = Folder::new();
    folder.write("stages.toml", CONFIG);
    let ran = folder.cvr(&["run", "stages.toml", "--device", "cpu", "--out", "out"]).exits(0);
    // raw: 3 sites × with and without skipping; hvq: optimised linear inline too, at 4 levels.
    assert!(ran.stdout.contains("38 cells: 38 ok, 0 failed"), "{}", ran.stdout);
    let results = Results::read(&folder.path("out/results.json")).unwrap();
    let of = |stages: Option<u8>| -> Vec<&Record> {
        results.records.iter().filter(|r| r.codec == "hvq" && r.stages == stages).collect()
    };
    let mut before: Option<&Record> = None;
    for stages in [Some(1), Some(2), Some(3)] {
        let cells = of(stages);
        assert_eq!(cells.len(), 8);
        for cell in &cells {
            assert_eq!((cell.status, cell.error_bound), (Status::Ok, None), "the bound is for all stages");
            // The sites draw the same level, and skipping does not change it.
            assert_eq!(cell.psnr_db, cells[0].psnr_db);
            assert_eq!(cell.image_psnr_db, cells[0].image_psnr_db, "{} {}", cell.site, cell.filter);
            assert!(!cell.skipping || cell.skipping_mismatches == Some(0));
            assert_eq!(cell.file_bytes, cells[0].file_bytes);
        }
        if let Some(before) = before {
            assert!(cells[0].psnr_db > before.psnr_db && cells[0].image_psnr_db > before.image_psnr_db);
            assert_eq!(cells[0].file_bytes, before.file_bytes, "one stream for all");
        }
        before = Some(cells[0]);
    }
    let all = of(None);
    assert_eq!(
        (all[0].psnr_db, all[0].image_psnr_db),
        (before.unwrap().psnr_db, before.unwrap().image_psnr_db)
    );
    assert!(all[0].error_bound.is_some());
    assert!(results.records.iter().filter(|r| r.codec == "raw").all(|r| r.stages.is_none()));
    let reasons: Vec<&str> = results.refused.iter().map(|r| r.reason.as_str()).collect();
    assert!(reasons.contains(&"stages 4: codec hvq has 3 stages; use 1 to 3, or \"all\""), "{reasons:?}");
    let none = "stages 2: codec raw has no stages that could be left out; use stages \"all\"";
    assert!(reasons.contains(&none), "{reasons:?}");
    let names: std::collections::BTreeSet<_> = results.records.iter().map(identity).collect();
    assert_eq!(names.len(), 38, "levels are cells of their own");
    let report = folder.text("out/report.html");
    assert!(report.contains("(stages 2)"), "the report tells levels apart");

    let again = folder.cvr(&["run", "stages.toml", "--device", "cpu", "--out", "out", "--resume"]).exits(0);
    assert!(again.stdout.contains("38 of 38 cells taken over; 0 encodings"), "{}", again.stdout);
}

#[test]
fn a_level_of_a_stream_is_decoded_and_drawn_on_the_command_line() {
    let folder = Folder::new();
    folder.write("v.raw", [7_u8; 64]);
    let raw = ["--dims", "4x4x4", "--dtype", "u8"];
    folder.cvr(&[&["encode", "v.raw", "v.cvr", "--codec", "hvq"][..], &raw].concat()).exits(0);
    folder.cvr(&["decode", "v.cvr", "one.nrrd", "--stages", "1"]).exits(0);
    folder.cvr(&["decode", "v.cvr", "all.nrrd"]).exits(0);
    assert!(folder.read("one.nrrd") == folder.read("all.nrrd"), "a constant volume is its mean");
    folder.cvr(&["render", "v.cvr", "v.png", "--device", "cpu", "--stages", "2"]).exits(0);
    let told = folder.cvr(&["shader", "v.cvr", "--stages", "2"]).exits(0);
    assert!(told.stdout.contains("fn hvq_stages()") && told.stdout.contains("2u"), "{}", told.stdout);
    let refused = folder.cvr(&["decode", "v.cvr", "no.nrrd", "--stages", "4"]).exits(2);
    assert!(refused.stderr.contains("codec hvq has 3 stages; use 1 to 3"), "{}", refused.stderr);
    assert!(!folder.path("no.nrrd").exists());
    let refused = folder.cvr(&[&["render", "v.raw", "no.png", "--stages", "1"][..], &raw].concat()).exits(2);
    assert!(refused.stderr.contains("codec raw has no stages"), "{}", refused.stderr);
}
