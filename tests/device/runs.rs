//! A whole experiment on the device, through the library and through the command.

use std::path::Path;
use std::process::{Command, Output};
use std::sync::atomic::AtomicBool;

use cvr::experiment::files::folder::OutFolder;
use cvr::experiment::files::results::Results;
use cvr::experiment::identity::experiment;
use cvr::experiment::inputs::volumes::load;
use cvr::experiment::records::provenance::Provenance;
use cvr::experiment::records::record::{Record, Status};
use cvr::experiment::running::outcome::Outcome;
use cvr::experiment::running::run::Run;
use cvr::registry::Names;
use cvr::site::target::Target;
use cvr_core::pipeline::{Capabilities, Document, resolve};
use cvr_engine::testing::test_device;

pub const CONFIG: &str = r##"
[experiment]
name = "tiny"
seed = 3

[[volume]]
name = "phantom"
generate = "shepp-logan"
dims = [24, 24, 24]
dtype = "u8"

[[codec]]
id = "raw"

[[codec]]
id = "s3dc"
block = 8
index_bits = 2

[pipeline]
renderer = ["raycasting"]
site = ["inline", "deferred", "host"]
filter = ["nearest", "linear", "optimised-linear"]

[[scene]]
name = "front"
size = [48, 48]
transfer_function = [[0.0, "#00000000"], [40.0, "#2040a010"], [120.0, "#ffb04060"], [255.0, "#ffffffc0"]]
"##;

pub fn run(names: &Names, config: &str, target: &Target, folder: &Path) -> Outcome {
    let document = Document::parse("tiny.toml", config).unwrap();
    let experiment = document.experiment(&names.known()).unwrap();
    let resolution = resolve(&experiment, &names.known(), &Capabilities::default());
    let volumes: Vec<_> = experiment.volumes.iter().map(|v| load(v, experiment.seed).unwrap()).collect();
    let provenance = Provenance::default();
    let out = OutFolder::adopt(folder, experiment::owner(&provenance)).unwrap();
    let run = Run {
        experiment: &experiment,
        resolution: &resolution,
        volumes: &volumes,
        names,
        target,
        reopen: &|| Err("this test opens its device once".to_owned()),
        out: &out,
        stop: &AtomicBool::new(false),
        report: &|_, _| {},
    };
    run.run(provenance).unwrap()
}

pub fn find<'a>(records: &'a [Record], codec: &str, site: &str, filter: &str) -> &'a Record {
    records.iter().find(|r| r.codec == codec && r.site == site && r.filter == filter).unwrap()
}

#[test]
fn every_cell_of_an_experiment_runs_and_keeps_its_promises() {
    let Some(device) = test_device("runs::experiment") else { return };
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(&Names::new().unwrap(), CONFIG, &Target::Device(device.clone()), folder.path());
    let records = &outcome.records;
    // Two codecs, three sites, nearest and linear; and optimised-linear if there is a fetch_cell.
    assert_eq!((records.len(), outcome.refused.len(), outcome.failed()), (13, 5, 0), "{records:#?}");
    for r in records {
        let name = format!("{} {} {}", r.codec, r.site, r.filter);
        assert_eq!((r.status, &r.error), (Status::Ok, &None), "{name}");
        assert_eq!(r.device, device.info().name, "{name}");
        // At the site host nothing passes through a shader that decodes.
        assert_eq!(r.parity_mismatches, (r.site != "host").then_some(0), "{name}");
        assert!(r.frame_ms.unwrap() > 0.0, "{name}");
        assert_eq!(r.device_decode_ms.is_some_and(|ms| ms > 0.0), r.site == "deferred", "{name}");
        assert!(r.relative_frame_time.unwrap() > 0.0, "{name}");
        assert!(r.frame_pairs.unwrap() >= 7, "{name}");
        assert!(r.max_abs_error.unwrap() <= r.error_bound.unwrap(), "{name}");
        for file in [r.image.as_ref().unwrap(), r.error_image.as_ref().unwrap()] {
            assert!(folder.path().join(file).is_file(), "{name}: no {file}");
        }
    }

    let bytes = |codec, site| find(records, codec, site, "linear").resident_bytes.unwrap();
    assert_eq!((bytes("raw", "inline"), bytes("raw", "host")), (24 * 24 * 24, 24 * 24 * 24));
    assert!(bytes("s3dc", "inline") * 2 < bytes("raw", "inline"), "{}", bytes("s3dc", "inline"));
    assert_eq!(bytes("s3dc", "host"), 4 * 24 * 24 * 24, "decoded values of s3dc are floats");
    // The texture, and the codec's buffers from which the device decoded it.
    for codec in ["raw", "s3dc"] {
        assert_eq!(bytes(codec, "deferred"), bytes(codec, "host") + bytes(codec, "inline"), "{codec}");
    }
    // Decoded once, for both filters: two timings would not be equal.
    for codec in ["raw", "s3dc"] {
        let [nearest, linear] = ["nearest", "linear"].map(|filter| find(records, codec, "deferred", filter));
        assert_eq!(nearest.device_decode_ms, linear.device_decode_ms, "{codec}");
        assert!(linear.device_decode_bytes > linear.resident_bytes, "{codec}");
    }
    let picture = |site| {
        std::fs::read(folder.path().join(find(records, "raw", site, "linear").image.as_ref().unwrap()))
    };
    assert!(picture("deferred").unwrap() == picture("host").unwrap(), "raw is exact");
    assert_eq!(find(records, "raw", "deferred", "linear").codec_image_psnr_db, Some(f64::INFINITY));

    // The baseline against itself: sanity, not speed.
    let baseline = find(records, "raw", "host", "linear");
    let relative = baseline.relative_frame_time.unwrap();
    assert!((0.3..3.0).contains(&relative), "raw against itself took {relative} times as long");

    // Raw inline with the manual filter is the reference itself. s3dc at 2 bits is not.
    assert_eq!(find(records, "raw", "inline", "linear").image_psnr_db, Some(f64::INFINITY));
    assert!(find(records, "s3dc", "inline", "linear").image_psnr_db.unwrap() < 60.0);
    assert_eq!(Results::read(&folder.path().join("results.json")).unwrap().records.len(), 13);
}

/// Raw and s3dc at all sites, in slices across an axis: the ring draws the same picture as the whole frame, with less
/// memory.
#[test]
fn a_ring_of_layers_runs_beside_the_other_sites() {
    let Some(device) = test_device("runs::ring") else { return };
    let config = CONFIG
        .replace("[\"raycasting\"]", "[\"raycasting\", \"slicing\"]\ngeometry = [\"planes\", \"axis\"]")
        .replace(
            "[\"inline\", \"deferred\", \"host\"]",
            "[\"inline\", \"deferred\", \"ring\"]\nskipping = [false, true]",
        )
        .replace(", \"optimised-linear\"", "");
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(&Names::new().unwrap(), &config, &Target::Device(device.clone()), folder.path());
    let of_ring: Vec<&Record> = outcome.records.iter().filter(|r| r.site == "ring").collect();
    // Three renderers, one of them can draw from a ring; two codecs, two filters, with and without skipping.
    assert_eq!((of_ring.len(), outcome.refused.len(), outcome.failed()), (8, 16, 0), "{of_ring:#?}");
    assert!(outcome.refused.iter().all(|r| r.reason.contains("renderers that do: slicing,geometry=axis")));
    for r in of_ring {
        let name = format!("{} {} {}", r.codec, r.filter, r.skipping);
        assert_eq!((r.status, r.parity_mismatches), (Status::Ok, Some(0)), "{name}");
        assert_eq!((r.device_decode_ms, r.device_decode_bytes), (None, None), "{name}");
        assert!(r.frame_pairs.unwrap() >= 7, "{name}");
        assert!(!r.notes.as_ref().is_some_and(|notes| notes.contains("mirror")), "{name}");
        let at = |site: &str| {
            let same = |other: &&Record| {
                (other.site.as_str(), other.skipping, &other.renderer) == (site, r.skipping, &r.renderer)
                    && (&other.codec, &other.filter) == (&r.codec, &r.filter)
            };
            outcome.records.iter().find(same).unwrap()
        };
        let (inline, whole) = (at("inline"), at("deferred"));
        let texel_bytes = if r.codec == "raw" { 1 } else { 4 };
        let ring = 4 * 24 * 24 * texel_bytes + 24 * 256;
        assert_eq!(r.resident_bytes, inline.resident_bytes.map(|stream| ring + stream), "{name}");
        assert!(r.resident_bytes < whole.resident_bytes, "{name}");
        // Under the nearest filter both read the very same texels.
        let bytes = |r: &Record| std::fs::read(folder.path().join(r.image.as_ref().unwrap())).unwrap();
        assert!(r.filter != "nearest" || bytes(r) == bytes(whole), "{name}");
        let [of_ring, of_frame] = [r, whole].map(|r| r.image_psnr_db.unwrap());
        assert!((of_ring - of_frame).abs() < 1.0, "{name}: {of_ring} and {of_frame} dB");
        assert_eq!(r.codec == "raw", r.codec_image_psnr_db == Some(f64::INFINITY), "{name}");
    }
}

fn cvr(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cvr")).args(arguments).current_dir(folder).output().unwrap()
}

#[test]
fn the_command_draws_on_the_device_that_is_named() {
    let Some(device) = test_device("runs::command") else { return };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tiny.toml"), CONFIG).unwrap();
    let name = &device.info().name;
    // A part of the name in another case.
    let part = name.split_whitespace().next().unwrap().to_uppercase();
    let backend = &device.info().backend;
    let one = ["--set", "pipeline.filter=[\"nearest\"]", "--set", "pipeline.site=[\"inline\"]"];
    for (chosen, out) in [(&part, "by-name"), (backend, "by-backend")] {
        let arguments = [&["run", "tiny.toml", "--out", out, "--device", chosen][..], &one].concat();
        let output = cvr(&arguments, folder.path());
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{errors}");
        assert!(errors.contains(&format!("drawing on {name}")), "{errors}");
        let results = Results::read(&folder.path().join(out).join("results.json")).unwrap();
        assert_eq!(results.provenance.adapter, *name);
        assert!(
            chosen != backend || results.provenance.backend == *backend,
            "{}",
            results.provenance.backend
        );
        assert_eq!(results.records.len(), 2);
        assert!(results.records.iter().all(|r| r.status == Status::Ok && r.device == *name));
        assert!(folder.path().join(out).join("report.html").is_file());
    }
}

#[test]
fn a_device_that_does_not_exist_is_bad_input_and_the_others_are_listed() {
    let Some(device) = test_device("runs::unknown_device") else { return };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tiny.toml"), CONFIG).unwrap();
    for wrong in ["no such adapter", "#99"] {
        let output = cvr(&["run", "tiny.toml", "--out", "out", "--device", wrong], folder.path());
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains(wrong) && errors.contains(&device.info().name), "{errors}");
        assert!(!folder.path().join("out/results.json").exists());
    }
}
