//! The records of cells that skip empty macrocells.

use cvr::experiment::files::results::Results;
use cvr::experiment::identity::cell::of_record as identity;
use cvr::experiment::records::record::{Record, Status};

use super::folder::Folder;
use super::volumes::floats;

const CONFIG: &str = r##"
[experiment]
name = "skip"
[[volume]]
name = "v"
file = "v.nrrd"
[[codec]]
id = "raw"
[[codec]]
id = "s3dc"
[pipeline]
renderer = ["raycasting", "slicing"]
geometry = ["planes", "shells"]
site = ["inline", "host"]
filter = "linear"
skipping = [false, true]
[[scene]]
name = "front"
size = [16, 16]
transfer_function = [[0, "#00000000"], [100, "#ffffff00"], [150, "#ffffffff"], [255, "#ffffffff"]]
[[scene]]
name = "whole"
size = [16, 16]
transfer_function = [[0, "#ffffff20"], [255, "#ffffffff"]]
"##;

#[test]
fn a_run_records_what_skipping_gains_and_that_it_changes_nothing() {
    let folder = Folder::new();
    folder.volume("v.nrrd", &floats([32, 24, 17], |p| if p[0] < 6 { 200.0 } else { 0.0 }));
    folder.write("skip.toml", CONFIG);
    let ran = folder.cvr(&["run", "skip.toml", "--device", "cpu", "--out", "out"]).exits(0);
    assert!(ran.stdout.contains("48 cells: 48 ok, 0 failed; 0 combinations refused"), "{}", ran.stdout);
    let results = Results::read(&folder.path("out/results.json")).unwrap();
    let plain = |r: &Record| Record {
        skipping: false,
        renderer: r.renderer.clone(),
        site: r.site.clone(),
        codec: r.codec.clone(),
        scene: r.scene.clone(),
        ..Record::default()
    };
    for [without, with] in results.records.as_chunks().0 {
        assert_eq!((without.skipping, with.skipping), (false, true));
        assert_eq!(plain(without), plain(with), "neighbours are of one cell");
        assert_eq!((with.status, with.skipping_mismatches), (Status::Ok, Some(0)));
        let own = [without.skipping_gain, without.skipping_gain_iqr, without.empty_macrocells];
        assert_eq!((own, without.skipping_mismatches, without.macrocell_seconds), ([None; 3], None, None));
        assert!(with.skipping_gain.unwrap() > 0.0 && with.skipping_gain_iqr.unwrap() >= 0.0);
        assert!(with.macrocell_seconds.unwrap() > 0.0);
        // Of four macrocells along x, only the first shows.
        let empty = if with.scene == "whole" { 0.0 } else { 0.75 };
        assert_eq!(with.empty_macrocells, Some(empty));
        assert_eq!(without.codec_image_psnr_db, with.codec_image_psnr_db);
        let picture = |r: &Record| folder.read(&format!("out/{}", r.image.as_ref().unwrap()));
        assert!(picture(without) == picture(with) && without.image != with.image);
    }
    // The ranges are decoded once per codec.
    let seconds = |codec: &str| -> Vec<f64> {
        let own = results.records.iter().filter(|r| r.codec == codec);
        let mut seconds: Vec<f64> = own.filter_map(|r| r.macrocell_seconds).collect();
        seconds.dedup();
        seconds
    };
    assert_eq!((seconds("raw").len(), seconds("s3dc").len()), (1, 1));
    let report = folder.text("out/report.html");
    assert!(report.contains("gain of skipping") && report.contains("no picture differs in any bit"));

    let again = folder.cvr(&["run", "skip.toml", "--device", "cpu", "--out", "out", "--resume"]).exits(0);
    assert!(again.stdout.contains("48 of 48 cells taken over; 0 encodings"), "{}", again.stdout);
    let other = ["run", "skip.toml", "--device", "cpu", "--out", "other", "--shard", "1/2"];
    folder.cvr(&other).exits(0);
    folder.cvr(&["merge", "other", "out", "--out", "both"]).exits(0);
    let merged = Results::read(&folder.path("both/results.json")).unwrap();
    let names = |results: &Results| -> Vec<_> { results.records.iter().map(identity).collect() };
    assert_eq!(names(&merged), names(&results), "cells with and without are two, and keep their order");
}
