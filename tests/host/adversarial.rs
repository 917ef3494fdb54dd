//! Extreme volumes through a whole run: each cell draws, or fails with a reason.

use cvr::experiment::files::results::Results;
use cvr::experiment::records::record::{Record, Status};
use cvr_core::volume::DenseVolume;

use super::folder::Folder;
use super::volumes::floats;

const CONFIG: &str = r##"
[experiment]
name = "hard"
[[volume]]
name = "v"
file = "v.nrrd"
[[codec]]
id = "raw"
bits = ["native", "8", "half"]
[[codec]]
id = "s3dc"
block = [4, "3x5x2"]
[pipeline]
renderer = "raycasting"
site = ["inline", "host"]
filter = ["nearest", "linear"]
[[scene]]
name = "front"
size = [12, 12]
camera = { zoom = 1.3 }
transfer_function_domain = "range"
transfer_function = [[0.0, "#4080ff10"], [1.0, "#ffffffc0"]]
"##;

/// Cells of [`CONFIG`].
const CELLS: usize = 5 * 2 * 2;

/// The records of a run on this volume. A failed cell has a reason; any other has a picture.
fn run(volume: &DenseVolume) -> Vec<Record> {
    let folder = Folder::new();
    folder.volume("v.nrrd", volume);
    folder.write("hard.toml", CONFIG);
    let ran = folder.cvr(&["run", "hard.toml", "--device", "cpu", "--out", "out"]);
    assert!(matches!(ran.code, Some(0 | 1)), "{ran:?}");
    let results = Results::read(&folder.path("out/results.json")).unwrap();
    let failed = results.records.iter().filter(|r| r.status == Status::Failed).count();
    assert_eq!(ran.code, Some(i32::from(failed > 0)), "{ran:?}");
    assert!(folder.path("out/report.html").is_file());
    assert_eq!(results.records.len(), CELLS);
    for record in &results.records {
        match record.status {
            Status::Ok => {
                let picture = folder.path(&format!("out/{}", record.image.as_ref().unwrap()));
                assert_eq!(image::open(picture).unwrap().to_rgb8().dimensions(), (12, 12));
                assert!(record.max_abs_error.unwrap() <= record.error_bound.unwrap(), "{record:?}");
            }
            Status::Failed => {
                let reason = record.error.as_ref().unwrap();
                assert!(reason.len() > 20, "no reason: {reason}");
            }
        }
    }
    results.records
}

/// All cells of a valid volume.
fn ok(volume: &DenseVolume) -> Vec<Record> {
    let records = run(volume);
    for record in &records {
        assert_eq!(record.status, Status::Ok, "{} {}: {:?}", record.codec, record.settings, record.error);
    }
    records
}

fn native(records: &[Record]) -> Vec<&Record> {
    records.iter().filter(|r| r.settings == "bits=native").collect()
}

#[test]
fn sizes_that_are_no_multiple_of_anything() {
    for size in [[1, 1, 1], [1, 1, 19], [23, 1, 1], [13, 17, 23]] {
        let records = ok(&floats(size, |[x, y, z]| ((x * 7 + y * 5 + z * 3) % 11) as f32));
        for record in native(&records) {
            assert_eq!(record.voxels, size.iter().map(|n| u64::from(*n)).product::<u64>());
            assert_eq!(record.max_abs_error, Some(0.0));
        }
    }
}

#[test]
fn constant_volumes() {
    for value in [0.0, -7.25, 1e30, -1e-30] {
        for record in run(&floats([5, 4, 3], |_| value)) {
            // Only half precision cannot hold the one value, and says so.
            let half = record.settings == "bits=half" && value.abs() > 65504.0;
            assert_eq!(record.status == Status::Failed, half, "{value}: {record:?}");
        }
    }
}

#[test]
fn numbers_that_are_none_are_replaced_and_counted() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e-40, -0.0, -1e-45];
    let volume = floats([6, 5, 4], |[x, y, z]| match (x + y + z) % 3 {
        0 => odd[x as usize],
        _ => (x * y) as f32 + 0.5,
    });
    let cvr_core::volume::Samples::F32(samples) = volume.samples() else { panic!("f32") };
    let expected = samples.iter().filter(|v| !v.is_finite() || v.is_subnormal()).count() as u64;
    assert!(expected > 20);
    for record in ok(&volume) {
        assert_eq!(record.replaced_samples, expected);
    }
    for record in ok(&floats([4; 3], |p| p[0] as f32)) {
        assert_eq!(record.replaced_samples, 0);
    }
}

#[test]
fn volumes_without_one_usable_number() {
    for value in [f32::NAN, f32::INFINITY, 1e-40] {
        for record in ok(&floats([4, 3, 5], |_| value)) {
            assert_eq!(record.replaced_samples, 60);
        }
    }
}

/// Renderers compute differences of values. If these overflowed, a picture would silently lack something.
#[test]
fn the_whole_range_of_single_precision_is_refused_with_a_reason() {
    let wild =
        |high: f32| floats([6, 5, 4], move |[x, y, z]| if (x + y + z) % 2 == 0 { high } else { -high });
    for record in run(&wild(3e38)) {
        assert_eq!(record.status, Status::Failed, "{} {}", record.codec, record.settings);
        let half = record.settings == "bits=half";
        assert!(half || record.error.as_ref().unwrap().contains("single precision"), "{record:?}");
    }
    let folder = Folder::new();
    folder.volume("v.nrrd", &wild(3e38));
    let message = folder.cvr(&["render", "v.nrrd", "v.png", "--device", "cpu"]).refused();
    assert!(message.contains("from -3e38 to 3e38"), "{message}");
    // Half of that range can be drawn by codecs that can hold it.
    let records = run(&wild(1.5e38));
    for record in native(&records) {
        assert_eq!((record.status, record.max_abs_error), (Status::Ok, Some(0.0)));
    }
    assert!(
        records.iter().all(|r| (r.status == Status::Failed) == (r.settings == "bits=half")),
        "{records:?}"
    );
}

#[test]
fn a_tiny_signal_on_a_huge_offset() {
    // 2^24 + 1 is no single-precision number; its neighbours are.
    let records = run(&floats([7, 6, 5], |[x, y, z]| 16_777_216.0 + 2.0 * ((x + y * z) % 4) as f32));
    for record in &records {
        let half = record.settings == "bits=half";
        assert_eq!(
            record.status == Status::Failed,
            half,
            "{} {}: {:?}",
            record.codec,
            record.settings,
            record.error
        );
    }
    assert!(native(&records).iter().all(|r| r.max_abs_error == Some(0.0)));
}

#[test]
fn steps_checkerboards_and_single_voxels() {
    ok(&floats([9, 8, 7], |[x, _, _]| if x < 4 { 0.0 } else { 1000.0 }));
    ok(&floats([9, 8, 7], |[x, y, z]| ((x + y + z) % 2) as f32));
    ok(&floats([9, 8, 7], |p| if p == [4, 4, 3] { 1.0 } else { 0.0 }));
}

/// The test of these tests: their check of each record can fail.
#[test]
#[should_panic(expected = "half")]
fn a_cell_that_fails_is_noticed() {
    ok(&floats([4; 3], |p| 70_000.0 + p[0] as f32));
}
