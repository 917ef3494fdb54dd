//! Ties and their borders, and which cell is which.

use std::path::{Path, PathBuf};

use super::*;
use crate::experiment::files::write_results::to_json;
use crate::experiment::records::provenance::{Provenance, VolumeProvenance};
use crate::experiment::records::record::tests::record;
use crate::experiment::records::record::{Record, Status};

fn quantity(field: &str) -> &'static Quantity {
    QUANTITIES.iter().find(|q| q.field == field).unwrap()
}

fn timed(ms: f64, iqr: f64) -> Record {
    Record { frame_ms: Some(ms), frame_ms_iqr: Some(iqr), ..record("v", "raw") }
}

#[test]
fn a_tie_is_where_the_middle_halves_of_two_measurements_meet() {
    let frame = quantity("frame_ms");
    let compare = |other: f64| frame.compare(&timed(10.0, 1.0), &timed(other, 0.1 * other), 0.5).unwrap();
    // 5 % on either side.
    assert!((compare(11.0).noise - 0.1).abs() < 1e-12);
    for (other, verdict) in [
        (10.0, Verdict::Tie),
        (10.99, Verdict::Tie),
        (11.01, Verdict::More),
        (9.1, Verdict::Tie),
        (9.08, Verdict::Less),
        (100.0, Verdict::More),
    ] {
        assert_eq!(compare(other).verdict, verdict, "{other}");
    }
    assert!((compare(5.0).change - 0.5).abs() < 1e-12);
    let exact = frame.compare(&timed(10.0, 0.0), &timed(10.001, 0.0), 0.5).unwrap();
    assert_eq!(exact.verdict, Verdict::More, "without spread nothing hides a change");
    let unknown = Record { frame_ms: Some(14.0), ..record("v", "raw") };
    assert_eq!(frame.compare(&timed(10.0, 0.0), &unknown, 0.5).unwrap().verdict, Verdict::Tie);
    assert_eq!(frame.compare(&timed(10.0, 0.0), &record("v", "raw"), 0.5), None);
}

#[test]
fn sizes_have_no_noise_and_decibels_that_of_their_digits() {
    let with = |bits: f64, psnr: f64| Record {
        bits_per_voxel: Some(bits),
        psnr_db: Some(psnr),
        encode_seconds: Some(bits),
        ..record("v", "raw")
    };
    let verdict = |field: &str, a: &Record, b: &Record| quantity(field).compare(a, b, 0.1).map(|c| c.verdict);
    let infinite = f64::INFINITY;
    assert_eq!(verdict("bits_per_voxel", &with(4.0, 40.0), &with(4.0, 40.0)), Some(Verdict::Tie));
    assert_eq!(verdict("bits_per_voxel", &with(4.0, 40.0), &with(4.001, 40.0)), Some(Verdict::More));
    assert_eq!(verdict("encode_seconds", &with(4.0, 40.0), &with(4.3, 40.0)), Some(Verdict::Tie));
    assert_eq!(verdict("encode_seconds", &with(4.0, 40.0), &with(3.6, 40.0)), Some(Verdict::Less));
    assert_eq!(verdict("psnr_db", &with(4.0, 40.0), &with(4.0, 40.004)), Some(Verdict::Tie));
    assert_eq!(verdict("psnr_db", &with(4.0, 40.0), &with(4.0, 39.99)), Some(Verdict::Less));
    assert_eq!(verdict("psnr_db", &with(4.0, infinite), &with(4.0, infinite)), Some(Verdict::Tie));
    assert_eq!(verdict("psnr_db", &with(4.0, 60.0), &with(4.0, infinite)), Some(Verdict::More));
    assert_eq!(verdict("psnr_db", &with(4.0, 60.0), &with(4.0, f64::NAN)), None);
    assert_eq!(verdict("bits_per_voxel", &with(4.0, 60.0), &with(0.0, 60.0)), None);
}

const CONFIG: &str = r##"
[experiment]
name = "x"
seed = 1
[[volume]]
name = "v"
generate = "turbulence"
dims = [4, 4, 4]
[[codec]]
id = "raw"
[pipeline]
renderer = "raycasting"
site = "inline"
filter = "linear"
[[scene]]
name = "front"
transfer_function = "tissue"
"##;

fn write(folder: &Path, name: &str, config: &str, volume: &str, records: &[Record]) -> PathBuf {
    let blake3 = "af13".into();
    let volumes = vec![VolumeProvenance { name: volume.into(), blake3, dims: [4; 3], ..Default::default() }];
    let provenance = Provenance {
        version: "9.8.7".into(),
        git_hash: Some("c0ffee".into()),
        cpu: "a processor".into(),
        cores: 3,
        date: "2026-11-23T00:00:00Z".into(),
        config: config.into(),
        volumes,
        ..Provenance::default()
    };
    let path = folder.join(name);
    std::fs::write(&path, to_json(&provenance, records, &[]).unwrap()).unwrap();
    path
}

fn cell(volume: &str, codec: &str, ms: f64) -> Record {
    Record {
        scene: "front".into(),
        site: "inline".into(),
        device: "one".into(),
        codec: codec.into(),
        ..Record { volume: volume.into(), ..timed(ms, 0.02 * ms) }
    }
}

#[test]
fn cells_are_matched_by_content_and_not_by_the_name_of_a_volume_or_a_machine() {
    let folder = tempfile::tempdir().unwrap();
    let first =
        [cell("v", "raw", 10.0), cell("v", "vq", 20.0), cell("v", "gone", 1.0), cell("v", "broken", 1.0)];
    let mut other = vec![cell("w", "vq", 20.25), cell("w", "raw", 5.0), cell("w", "new", 1.0)];
    other.push(Record {
        status: Status::Failed,
        error: Some("no memory".into()),
        ..cell("w", "broken", 1.0)
    });
    other.iter_mut().for_each(|r| r.device = "two".into());
    let a = write(folder.path(), "a.json", CONFIG, "v", &first);
    let b = write(folder.path(), "b.json", CONFIG, "w", &other);
    let sides = read(&[a.clone(), b]).unwrap();
    let pairing = pair(&sides[0], &sides[1]);
    let both: Vec<(&str, &str)> =
        pairing.both.iter().map(|m| (m.first.codec.as_str(), m.other.codec.as_str())).collect();
    assert_eq!(both, [("raw", "raw"), ("vq", "vq")]);
    let codecs = |records: &[&Record]| records.iter().map(|r| r.codec.clone()).collect::<Vec<_>>();
    assert_eq!(codecs(&pairing.only_first), ["gone"]);
    assert_eq!(codecs(&pairing.only_other), ["new"]);
    assert_eq!(pairing.failed.len(), 1);
    insta::assert_snapshot!(text(&sides, 0.1).replace(&folder.path().display().to_string(), "FOLDER"));

    let rows = csv(&sides, 0.1).unwrap();
    let mut reader = csv::Reader::from_reader(rows.as_slice());
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let frames: Vec<(&str, &str, &str)> =
        rows.iter().filter(|r| &r[11] == "frame_ms").map(|r| (&r[3], &r[14], &r[16])).collect();
    assert_eq!(frames, [("raw", "0.5", "less"), ("vq", "1.0125", "tie")]);

    // Other samples, another scene under the same name, and one cell twice are not the same.
    let text = std::fs::read_to_string(&a).unwrap();
    for (from, to) in [("af13", "bf13"), ("tissue", "surface")] {
        let c = folder.path().join("c.json");
        std::fs::write(&c, text.replace(from, to)).unwrap();
        let sides = read(&[a.clone(), c]).unwrap();
        assert!(pair(&sides[0], &sides[1]).both.is_empty(), "{from} and {to} are told apart");
    }
    // A configuration that this version does not read leaves the scene's name.
    let d = folder.path().join("d.json");
    std::fs::write(&d, text.replace("generate = ", "of_the_future = ")).unwrap();
    let sides = read(&[a.clone(), d]).unwrap();
    assert!(sides[0].scenes_by_name);
    assert_eq!(pair(&sides[0], &sides[1]).both.len(), 4);
}

#[test]
fn a_file_of_two_devices_is_two_runs_and_no_cell_is_matched_twice() {
    let folder = tempfile::tempdir().unwrap();
    let elsewhere = Record { device: "two".into(), ..cell("v", "raw", 30.0) };
    let records = [cell("v", "raw", 10.0), elsewhere, cell("v", "raw", 11.0)];
    let path = write(folder.path(), "results.json", CONFIG, "v", &records);
    let sides = read(&[folder.path().to_owned()]).unwrap();
    assert_eq!(sides.iter().map(|s| s.file == path).collect::<Vec<_>>(), [true, true]);
    assert_eq!(sides[0].software, "cvr 9.8.7 (c0ffee)");
    let pairing = pair(&sides[0], &sides[1]);
    assert_eq!((pairing.both.len(), pairing.only_first.len(), pairing.only_other.len()), (1, 1, 0));
}

#[test]
fn what_holds_no_results_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = folder.path().join("wrong.json");
    for text in ["", "{}", "[]", "{\"provenance\": 1}"] {
        std::fs::write(&wrong, text).unwrap();
        let error = read(std::slice::from_ref(&wrong)).unwrap_err().to_string();
        assert!(error.contains("wrong.json"), "{error}");
    }
    let empty = write(folder.path(), "empty.json", CONFIG, "v", &[]);
    assert!(read(&[empty]).unwrap_err().to_string().contains("no cell was run"));
    assert!(read(&[folder.path().join("missing.json")]).unwrap_err().to_string().contains("missing.json"));
}

#[test]
fn methods_of_a_codec_are_told_apart() {
    let cell = |payload: &str, rate: u32, seconds: f64| Record {
        settings: format!("payload={payload} rate={rate} seed=1"),
        series: format!("payload={payload}"),
        encode_seconds: Some(seconds),
        ..record("v", "tvq")
    };
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, seconds: f64| {
        let path = folder.path().join(name);
        let records = [cell("fixed", 1, 1.0), cell("fixed", 2, 1.0), cell("variable", 1, seconds)];
        std::fs::write(&path, to_json(&Provenance::default(), &records, &[]).unwrap()).unwrap();
        path
    };
    let text = text(&read(&[write("a.json", 1.0), write("b.json", 4.0)]).unwrap(), 0.1);
    let line = |start: &str| {
        let found = text.lines().find(|line| line.starts_with(start));
        found.unwrap_or_else(|| panic!("{start}: {text}")).split_whitespace().collect::<Vec<_>>().join(" ")
    };
    assert_eq!(line("tvq payload=fixed "), "tvq payload=fixed 2 tie");
    assert_eq!(line("tvq payload=variable "), "tvq payload=variable 1 4.000");
    assert_eq!(line("v tvq payload=fixed rate=2 "), "v tvq payload=fixed rate=2 tie", "no shared setting");
}

#[test]
fn the_page_tells_better_from_worse_and_text_stays_text() {
    let evil = "<script>alert(1)</script>";
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, seconds: f64, psnr: f64, ms: f64| {
        let path = folder.path().join(name);
        let cell = |volume: &str| Record {
            encode_seconds: Some(seconds),
            psnr_db: Some(psnr),
            scene: evil.into(),
            ..Record { volume: volume.into(), ..timed(ms, 1.0) }
        };
        let failed = Record { status: Status::Failed, error: Some(evil.into()), ..cell("broken") };
        std::fs::write(
            &path,
            to_json(&Provenance::default(), &[cell("v"), failed, record(name, "vq")], &[]).unwrap(),
        )
        .unwrap();
        path
    };
    let sides = read(&[write("a.json", 1.0, 40.0, 10.0), write("b.json", 0.5, 41.0, 10.5)]).unwrap();
    let html = page(&sides, 0.1).unwrap();
    let cells = |html: &str, class: &str| html.matches(&format!("<td class=\"n {class}\"")).count();
    // Half the time and a decibel more are better, and the frame times tie: by codec, and cell by cell.
    assert_eq!(["better", "worse", "tie"].map(|class| cells(&html, class)), [4, 0, 2], "{html}");
    for told in [">0.500</td>", ">0.500<small>", ">+1.00</td>", ">tie</td>"] {
        assert!(html.contains(told), "{told}: {html}");
    }
    let back = page(&[sides[1].clone(), sides[0].clone()], 0.1).unwrap();
    assert_eq!(["better", "worse", "tie"].map(|class| cells(&back, class)), [0, 4, 2]);
    assert!(!html.contains("<script") && html.contains("&lt;script&gt;"));
    for foreign in ["http://", "https://", "url(", "<link", "<img"] {
        assert!(!html.contains(foreign), "{foreign}");
    }
    for list in ["1 cell only in A", "1 cell only in B", "1 cell failed in one or both"] {
        assert!(html.contains(list), "{list}");
    }
}
