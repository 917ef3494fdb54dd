//! The results of a run: records, cells, pictures, report.

use std::sync::OnceLock;

use cvr::experiment::files::results::Results;
use cvr::experiment::records::record::{Record, Status};
use serde_json::Value;

use super::folder::Folder;

/// One scene, two codecs, three sites, two filters: 12 cells.
const CONFIG: &str = r##"
[experiment]
name = "tiny"
seed = 7
[[volume]]
name = "noise"
generate = "turbulence"
dims = [16, 16, 16]
[[codec]]
id = "raw"
[[codec]]
id = "s3dc"
block = 4
index_bits = 2
[pipeline]
renderer = "raycasting"
site = ["inline", "deferred", "host"]
filter = ["nearest", "linear"]
[[scene]]
name = "front"
size = [32, 32]
transfer_function = [[60, "#00000000"], [140, "#d08040c0"], [255, "#ffffffff"]]
"##;

/// The columns that other programs rely on, in their order.
const COLUMNS: &str = "volume, codec, settings, site, filter, renderer, scene, device, driver, status, error, voxels, \
    frames, bits_per_voxel, file_bytes, resident_bytes, encode_seconds, decode_seconds, decode_voxels_per_second, \
    psnr_db, foreground_psnr_db, max_abs_error, error_bound, image_psnr_db, image_ssim, codec_image_psnr_db, \
    codec_image_ssim, frame_ms, frame_ms_iqr, frame_cpu_ms, frame_clock, relative_frame_time, image";

/// The same experiment, run twice, into `a` and `b`.
fn runs() -> &'static Folder {
    static RUNS: OnceLock<Folder> = OnceLock::new();
    RUNS.get_or_init(|| {
        let folder = Folder::new();
        folder.write("tiny.toml", CONFIG);
        for out in ["a", "b"] {
            let ran = folder.cvr(&["run", "tiny.toml", "--device", "cpu", "--out", out]).exits(0);
            assert!(
                ran.stdout.contains("12 cells: 12 ok, 0 failed; 0 combinations refused"),
                "{}",
                ran.stdout
            );
            assert!(ran.stdout.contains("report.html"), "{}", ran.stdout);
        }
        folder
    })
}

fn results(run: &str) -> Results {
    Results::read(&runs().path(&format!("{run}/results.json"))).unwrap()
}

fn record(codec: &str, site: &str, filter: &str) -> Record {
    let mut records = results("a").records.into_iter();
    records.find(|r| (&*r.codec, &*r.site, &*r.filter) == (codec, site, filter)).unwrap()
}

#[test]
fn columns_have_the_names_and_the_order_that_last() {
    let text = runs().text("a/results.csv");
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let expected: Vec<&str> = COLUMNS.split(", ").map(str::trim).collect();
    assert_eq!(header[..expected.len()], expected, "more may follow, but nothing else may come before");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let read: Vec<Record> = reader.deserialize().collect::<Result<_, _>>().unwrap();
    for (csv, mut json) in read.iter().zip(results("a").records) {
        if json.max_abs_error == Some(0.0) {
            // `null` in JSON: no foreground, or a foreground without errors. CSV distinguishes the two.
            assert_eq!((csv.foreground_psnr_db, json.foreground_psnr_db), (Some(f64::INFINITY), None));
            json.foreground_psnr_db = csv.foreground_psnr_db;
        }
        assert_eq!(*csv, json, "CSV and JSON tell the same");
    }
    assert_eq!(read.len(), 12);
}

#[test]
fn results_tell_where_they_come_from() {
    let json = runs().json("a/results.json");
    let keys: Vec<&String> = json.as_object().unwrap().keys().collect();
    assert!(keys.iter().any(|k| *k == "provenance") && keys.iter().any(|k| *k == "records"), "{keys:?}");
    let provenance = &json["provenance"];
    for key in ["version", "git_hash", "adapter", "driver", "backend", "cpu", "volumes", "seed", "config"] {
        assert!(provenance.get(key).is_some(), "no {key} in {provenance}");
    }
    assert_eq!(provenance["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(provenance["adapter"], "cpu");
    assert_eq!(provenance["seed"], 7);
    assert_eq!(provenance["config"], CONFIG, "the configuration, letter by letter");
    assert!(!provenance["cpu"].as_str().unwrap().is_empty());
    let volume = &provenance["volumes"][0];
    assert_eq!((volume["name"].as_str(), volume["dtype"].as_str()), (Some("noise"), Some("u8")));
    let samples = super::volumes::seeded(
        cvr::input::Generator::Turbulence,
        [16; 3],
        cvr_core::volume::SampleType::U8,
        7,
    );
    let hash = blake3::hash(samples.samples().as_bytes()).to_hex();
    assert_eq!(volume["blake3"], hash.as_str(), "of the samples");
}

/// Results that people pass on contain no folder of this machine.
#[test]
fn results_hold_no_path_of_this_machine() {
    let folder = runs();
    let root = folder.root().to_str().unwrap();
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_cvr")).parent().unwrap().to_str().unwrap();
    for name in ["a/results.json", "a/results.csv", "a/report.html"] {
        let text = folder.text(name);
        assert!(!text.contains(root) && !text.contains(program), "{name}");
    }
}

#[test]
fn every_cell_has_a_record_of_its_own() {
    let folder = runs();
    let json = folder.json("a/results.json");
    let names = folder.names();
    let mut cells: Vec<Value> = names
        .iter()
        .filter(|n| n.starts_with("a/cells/") && n.ends_with(".json"))
        .map(|n| folder.json(n))
        .collect();
    for cell in &mut cells {
        // Fields of a cell's file besides the record.
        let fields = cell.as_object_mut().unwrap();
        assert_eq!(fields.remove("digest").unwrap().as_str().unwrap().len(), 64);
        assert_eq!(fields.remove("key").unwrap().as_str().unwrap().len(), 64);
        assert_eq!(fields.remove("pictures").unwrap().as_object().unwrap().len(), 4);
        assert!(fields.remove("not_finite").is_some());
    }
    assert_eq!(cells.len(), 12, "{names:?}");
    for record in json["records"].as_array().unwrap() {
        assert_eq!(cells.iter().filter(|c| *c == record).count(), 1, "{record}");
    }
    let rest = names.iter().filter(|n| n.starts_with("a/") && n.matches('/').count() == 1);
    let rest: Vec<&String> = rest.collect();
    let expected = [
        "cells",
        "charts",
        "cvr-files.jsonl",
        "errors",
        "images",
        "report.html",
        "results.csv",
        "results.json",
    ];
    assert_eq!(rest, expected.map(|name| format!("a/{name}")).iter().collect::<Vec<_>>());
}

#[test]
fn pictures_are_there_and_show_something() {
    let folder = runs();
    let results = results("a");
    let references = results.provenance.references.iter().map(|r| r.image.clone());
    let pictures = results.records.iter().map(|r| r.image.clone().unwrap()).chain(references);
    let mut count = 0;
    for name in pictures {
        let picture = image::open(folder.path(&format!("a/{name}"))).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (32, 32), "{name}");
        assert!(!blank(&picture), "{name}");
        count += 1;
    }
    assert_eq!(count, 13);
    for record in &results.records {
        let name = record.error_image.as_ref().unwrap();
        assert!(image::open(folder.path(&format!("a/{name}"))).is_ok(), "{name}");
    }
}

/// Fewer than a tenth of the pixels differ from the corner.
fn blank(picture: &image::RgbImage) -> bool {
    let corner = picture.get_pixel(0, 0);
    let other = picture.pixels().filter(|p| *p != corner).count();
    other * 10 < picture.pixels().len()
}

#[test]
fn a_blank_picture_is_noticed() {
    let mut picture = image::RgbImage::from_pixel(32, 32, image::Rgb([3, 3, 3]));
    assert!(blank(&picture));
    picture.pixels_mut().skip(500).take(200).for_each(|p| p.0 = [90, 0, 0]);
    assert!(!blank(&picture));
}

#[test]
fn the_report_stands_alone() {
    let report = runs().text("a/report.html");
    assert!(report.trim_start().to_lowercase().starts_with("<!doctype html>"));
    assert!(!fetches(&report), "a report needs no network");
    for word in ["tiny", "noise", "s3dc", "raycasting", "turbulence"] {
        assert!(report.contains(word), "the report does not mention {word}");
    }
}

/// Whether a page refers to the network. Names of XML namespaces are not references.
fn fetches(page: &str) -> bool {
    let page = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    let page = page.replace("xmlns:xlink=\"http://www.w3.org/1999/xlink\"", "");
    ["http://", "https://", "src=\"//", "href=\"//", "url(//"].iter().any(|word| page.contains(word))
}

#[test]
fn a_reference_into_the_network_is_noticed() {
    assert!(fetches("<script src=\"https://cdn.example/x.js\"></script>"));
    assert!(fetches("<img src=\"//cdn.example/x.png\">"));
    assert!(!fetches("<svg xmlns=\"http://www.w3.org/2000/svg\"><a href=\"#table\"/></svg>"));
}

#[test]
fn the_same_experiment_gives_the_same_pictures_and_sizes() {
    let (a, b) = (results("a"), results("b"));
    assert_eq!(a.records.len(), b.records.len());
    for (a, b) in a.records.iter().zip(&b.records) {
        assert_eq!((a.file_bytes, a.psnr_db, a.image_psnr_db), (b.file_bytes, b.psnr_db, b.image_psnr_db));
        let (name, folder) = (a.image.as_ref().unwrap(), runs());
        assert_eq!(folder.read(&format!("a/{name}")), folder.read(&format!("b/{name}")), "{name}");
    }
    assert_ne!(
        runs().read(&format!("a/{}", a.records[0].image.as_ref().unwrap())),
        runs().read(&format!("a/{}", a.records[7].image.as_ref().unwrap())),
        "different cells give different pictures"
    );
}

#[test]
fn another_seed_gives_another_volume() {
    let folder = Folder::new();
    folder.write("tiny.toml", CONFIG);
    let other = [
        "run",
        "tiny.toml",
        "--device",
        "cpu",
        "--set",
        "experiment.seed=8",
        "--set",
        "pipeline.site=host",
        "--set",
        "pipeline.filter=linear",
    ];
    folder.cvr(&other).exits(0);
    let other = Results::read(&folder.path("results/tiny/results.json")).unwrap();
    assert_eq!(other.provenance.seed, 8);
    assert_ne!(other.provenance.volumes[0].blake3, results("a").provenance.volumes[0].blake3);
}

#[test]
fn raw_equals_the_reference_and_s3dc_comes_close() {
    for site in ["inline", "deferred", "host"] {
        let raw = record("raw", site, "linear");
        assert_eq!((raw.psnr_db, raw.max_abs_error), (Some(f64::INFINITY), Some(0.0)));
        assert_eq!((raw.image_psnr_db, raw.image_ssim), (Some(f64::INFINITY), Some(1.0)));
        assert_eq!(raw.codec_image_psnr_db, Some(f64::INFINITY));
        let nearest = record("raw", site, "nearest");
        assert!(nearest.image_psnr_db.unwrap() < 60.0, "another filter is another picture");
        assert_eq!(nearest.codec_image_psnr_db, Some(f64::INFINITY), "but raw is itself");
        for filter in ["nearest", "linear"] {
            let s3dc = record("s3dc", site, filter);
            assert!((15.0..60.0).contains(&s3dc.codec_image_psnr_db.unwrap()), "{s3dc:?}");
            assert!((20.0..60.0).contains(&s3dc.psnr_db.unwrap()), "{s3dc:?}");
            assert!(s3dc.max_abs_error.unwrap() <= s3dc.error_bound.unwrap());
            assert!(s3dc.max_abs_error.unwrap() > 0.0);
        }
    }
    let row = runs()
        .text("a/results.csv")
        .lines()
        .find(|l| l.contains("inline,linear") && l.contains("raw"))
        .map(str::to_owned);
    assert!(row.unwrap().contains(",inf,"), "infinity has a name in CSV");
}

#[test]
fn the_mirror_draws_the_same_at_all_sites() {
    for codec in ["raw", "s3dc"] {
        for filter in ["nearest", "linear"] {
            let [inline, deferred, host] = ["inline", "deferred", "host"].map(|site| {
                let name = record(codec, site, filter).image.unwrap();
                runs().read(&format!("a/{name}"))
            });
            assert_eq!(inline, host, "{codec} {filter}");
            assert_eq!(deferred, host, "{codec} {filter}");
        }
    }
}

/// The mirror has no ring of layers. It still draws the picture, and names its source.
#[test]
fn the_mirror_draws_no_ring_and_says_so() {
    let folder = Folder::new();
    let config = CONFIG
        .replace("\"raycasting\"", "[\"raycasting\", \"slicing\"]\ngeometry = \"axis\"")
        .replace("[\"inline\", \"deferred\", \"host\"]", "[\"deferred\", \"ring\"]");
    folder.write("tiny.toml", config);
    let ran = folder.cvr(&["run", "tiny.toml", "--device", "cpu", "--out", "a"]).exits(0);
    assert!(ran.stdout.contains("12 cells: 12 ok, 0 failed; 4 combinations refused"), "{}", ran.stdout);
    let results = Results::read(&folder.path("a/results.json")).unwrap();
    let image = |r: &Record| folder.read(&format!("a/{}", r.image.as_ref().unwrap()));
    for codec in ["raw", "s3dc"] {
        for filter in ["nearest", "linear"] {
            let of = |site: &str| {
                let same = |r: &&Record| (&*r.codec, &*r.filter, &*r.site) == (codec, filter, site);
                results.records.iter().filter(same).find(|r| r.renderer == "slicing,geometry=axis").unwrap()
            };
            let (ring, whole) = (of("ring"), of("deferred"));
            assert!(ring.notes.as_ref().unwrap().contains("CPU mirror has no ring"), "{:?}", ring.notes);
            assert!(!whole.notes.as_ref().unwrap().contains("ring"), "{:?}", whole.notes);
            assert!(ring.shader_not_run() && whole.shader_not_run(), "{:?}", ring.notes);
            assert_eq!((ring.resident_bytes, ring.parity_mismatches), (None, None));
            assert_eq!(image(ring), image(whole), "{codec} {filter}");
        }
    }
}

#[test]
fn records_are_complete_and_consistent() {
    for record in results("a").records {
        let id = format!("{} {} {}", record.codec, record.site, record.filter);
        assert_eq!((record.status, record.error.as_ref()), (Status::Ok, None), "{id}");
        assert_eq!((record.voxels, record.frames, &*record.device), (4096, 1, "cpu"), "{id}");
        let bits = record.file_bytes.unwrap() as f64 * 8.0 / 4096.0;
        assert!((record.bits_per_voxel.unwrap() - bits).abs() < 1e-9, "{id}");
        let rate = 4096.0 / record.decode_seconds.unwrap();
        assert!((record.decode_voxels_per_second.unwrap() / rate - 1.0).abs() < 1e-6, "{id}");
        assert!(record.encode_seconds.unwrap() > 0.0 && record.frame_ms.unwrap() > 0.0, "{id}");
        assert!(record.relative_frame_time.unwrap() > 0.0 && record.frame_pairs.unwrap() >= 7, "{id}");
        assert_eq!(record.frame_clock.as_deref(), Some("wall"), "{id}: a CPU has no timestamps");
        assert_eq!((record.filtering.as_deref(), record.resident_bytes), (Some("manual"), None), "{id}");
        assert_eq!((record.replaced_samples, record.parity_mismatches), (0, None), "{id}");
        assert_eq!(record.shader_not_run(), record.site != "host", "{id}: {:?}", record.notes);
        assert_eq!(record.device_decode_ms, None, "{id}: no device decodes");
    }
}
