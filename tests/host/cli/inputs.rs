//! Volumes of every format on the command line: the output of `info`, and the result of `convert`.

use std::path::PathBuf;

use cvr::input::{Generator, generate_frames, open, write_npy, write_nrrd};
use cvr_core::volume::{BrickSource as _, DenseVolume, Extent, SampleType, Samples, VolumeLayout};

use super::super::configs::COMPARE;
use super::super::folder::Folder;

fn foreign(name: &str) -> String {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/input/tests/foreign");
    folder.join(name).to_str().unwrap().to_owned()
}

/// Colours over time, spaced.
fn moving_colours() -> DenseVolume {
    let extent = Extent::new(4, 3, 2).unwrap();
    let layout = VolumeLayout {
        channels: 3,
        frames: 5,
        spacing: [0.5, 1.0, 2.5],
        ..VolumeLayout::scalar(extent, SampleType::U16)
    };
    let samples = (0..layout.samples() as u16).map(|i| i.wrapping_mul(257)).collect();
    DenseVolume::new(layout, Samples::U16(samples)).unwrap()
}

#[test]
fn info_tells_what_a_volume_is() {
    let folder = Folder::new();
    for (name, lines) in [
        (
            "nifti-gz-i16-t.nii.gz",
            &["dims       5×4×3", "samples    i16, 1 per voxel, 2 frame(s)", "spacing    0.5 1.25 2"][..],
        ),
        ("nifti-rgb24-u8-rgb.nii.gz", &["samples    u8, 3 per voxel, 1 frame(s)"]),
        ("scaled-i16.nii", &["stored     i16, kept as f32", "range      -23 to -6.5"]),
        ("vti-appendedrawzlib-i64.vti", &["stored     i64, kept as f32", "range      -40 to -7"]),
        ("npy-fortran-f32-rgb-t.npy", &["samples    f32, 3 per voxel, 2 frame(s)", "spacing    1 1 1"]),
        ("tiff-lzw-u16.tif", &["range      0 to 33", "samples    u16"]),
        ("png-u8-rgb", &["dims       5×4×3", "samples    u8, 3 per voxel"]),
    ] {
        let told = folder.cvr(&["info", &foreign(name)]).exits(0).stdout;
        for line in lines.iter().chain([&"histogram  |", &"blake3     "]) {
            assert!(told.contains(line), "{name}: no {line:?} in {told}");
        }
        assert!(!told.contains("rounded"), "{told}");
    }
}

#[test]
fn what_is_rounded_is_told_by_info_encode_container_and_record() {
    let folder = Folder::new();
    let doubles: Vec<u8> = (0..64).flat_map(|i| (f64::from(i) + 0.1).to_le_bytes()).collect();
    folder.write("v.raw", &doubles);
    let layout = ["--dims", "4x4x4", "--dtype", "f64"];
    let told = folder.cvr(&[&["info", "v.raw"][..], &layout].concat()).exits(0).stdout;
    assert!(told.contains("stored     f64, kept as f32"), "{told}");
    assert!(told.contains("rounded    64 samples, to single precision"), "{told}");
    let encoded =
        folder.cvr(&[&["encode", "v.raw", "v.cvr", "--codec", "raw"][..], &layout].concat()).exits(0);
    assert!(encoded.stdout.contains("64 samples were rounded to single precision"), "{}", encoded.stdout);
    let told = folder.cvr(&["info", "v.cvr"]).exits(0).stdout;
    assert!(told.contains("rounded    64 samples, to single precision"), "{told}");

    folder.write("x.toml", COMPARE);
    let run = [
        "run",
        "x.toml",
        "--device",
        "cpu",
        "--out",
        "out",
        "--volume",
        "v.raw",
        "--set",
        "scene.size=[8, 8]",
    ];
    folder.cvr(&[&run[..], &layout].concat()).exits(0);
    for record in folder.json("out/results.json")["records"].as_array().unwrap() {
        let notes = record["notes"].as_str().unwrap_or_default();
        assert!(notes.contains("64 samples of the input were rounded to single precision"), "{record}");
    }
}

#[test]
fn convert_keeps_channels_and_frames() {
    let folder = Folder::new();
    let volume = moving_colours();
    write_nrrd(&folder.path("a.nrrd"), &volume).unwrap();
    let told = folder.cvr(&["convert", "a.nrrd", "b.npy"]).exits(0).stdout;
    assert!(told.contains("b.npy: 4×3×2 of u16, 3 per voxel, 5 frame(s)"), "{told}");
    assert!(told.contains("read it with --spacing 0.5,1,2.5"), "{told}");
    let told = folder.cvr(&["convert", "b.npy", "c.raw", "--spacing", "0.5,1,2.5"]).exits(0).stdout;
    let line = told.lines().find_map(|l| l.strip_prefix("read it with ")).unwrap();
    let layout: Vec<&str> = line.split(' ').collect();
    folder.cvr(&[&["convert", "c.raw", "d.nrrd"][..], &layout].concat()).exits(0);
    assert_eq!(open(&folder.path("d.nrrd")).unwrap(), volume);
    assert_eq!(folder.read("a.nrrd"), folder.read("d.nrrd"));
    assert_eq!(folder.names(), ["a.nrrd", "b.npy", "c.raw", "d.nrrd"]);
}

#[test]
fn every_frame_is_encoded_and_decoded() {
    let folder = Folder::new();
    let extent = Extent::new(6, 5, 4).unwrap();
    let volume = generate_frames(Generator::AdvectedBlobs, extent, 3, SampleType::U16, 3).unwrap();
    write_npy(&folder.path("v.npy"), &volume).unwrap();
    folder.cvr(&["encode", "v.npy", "v.cvr", "--codec", "raw"]).exits(0);
    folder.cvr(&["decode", "v.cvr", "back.nrrd"]).exits(0);
    assert_eq!(open(&folder.path("back.nrrd")).unwrap(), volume);
}

#[test]
fn convert_joins_files_and_patterns() {
    let folder = Folder::new();
    let extent = Extent::new(6, 5, 4).unwrap();
    let all = generate_frames(Generator::AdvectedBlobs, extent, 12, SampleType::U8, 3).unwrap();
    let Samples::U8(samples) = all.samples() else { panic!("8 bits") };
    for (frame, number) in samples.chunks_exact(120).zip(1..) {
        let one = VolumeLayout::scalar(extent, SampleType::U8);
        let one = DenseVolume::new(one, Samples::U8(frame.to_vec())).unwrap();
        write_npy(&folder.path(&format!("step{number}.npy")), &one).unwrap();
    }
    folder.cvr(&["convert", "step*.npy", "all.nrrd"]).exits(0);
    assert_eq!(open(&folder.path("all.nrrd")).unwrap(), all);
    folder.cvr(&["convert", "step2.npy", "step1.npy", "two.npy"]).exits(0);
    let two = open(&folder.path("two.npy")).unwrap();
    assert_eq!(two.layout().frames, 2);
    assert_eq!(two.samples(), &Samples::U8([&samples[120..240], &samples[..120]].concat()));
    let told = folder.cvr(&["info", "step*.npy"]).exits(0).stdout;
    assert!(told.contains("12 frame(s)"), "{told}");
}

#[test]
fn convert_refuses_what_it_cannot_do() {
    let folder = Folder::new();
    write_nrrd(&folder.path("a.nrrd"), &moving_colours()).unwrap();
    folder.write("b.cvr", "no matter what");
    for (arguments, words) in [
        (&["a.nrrd", "b.tif"][..], ".npy (a NumPy array) or .raw"),
        (&["a.nrrd", "a.nrrd"], "is the input"),
        (&["a.nrrd", "no/b.npy"], "the folder no does not exist"),
        (&["b.cvr", "c.npy"], "cvr decode"),
        (&["gone.nrrd", "c.npy"], "gone.nrrd"),
        (&["?.nrrd", "a.nrrd"], "is the input"),
        (&["gone*.nrrd", "c.npy"], "no file matches the pattern"),
    ] {
        let message = folder.cvr(&[&["convert"][..], arguments].concat()).refused();
        assert!(message.contains(words), "{arguments:?}: {message}");
    }
    let message = folder.cvr(&["info", "a.nrrd", "b.cvr"]).refused();
    assert!(message.contains("b.cvr is encoded"), "{message}");
    assert_eq!(folder.names(), ["a.nrrd", "b.cvr"]);
}

#[test]
fn experiments_run_on_volumes_of_any_format() {
    let folder = Folder::new();
    folder.write("x.toml", COMPARE);
    let quick = ["--device", "cpu", "--out", "out", "--overwrite", "--set", "scene.size=[8, 8]"];
    for (name, called) in [
        ("nifti-gz-i16-t.nii.gz", "nifti-gz-i16-t"),
        ("vti-appendedrawzlib-i64.vti", "vti-appendedrawzlib-i64"),
        ("png-u16", "png-u16"),
    ] {
        let ran = folder.cvr(&[&["run", "x.toml", "--volume", &foreign(name)][..], &quick].concat()).exits(0);
        assert!(ran.stdout.contains(" 0 failed"), "{}", ran.stdout);
        let results = folder.json("out/results.json");
        assert_eq!(results["records"][0]["volume"], called);
        assert_eq!(results["provenance"]["volumes"][0]["source"], name);
    }
    let two = [foreign("nrrd-u8.nrrd"), foreign("nrrd-u8.nrrd")];
    folder.cvr(&[&["run", "x.toml", "--volume", &two[0], "--volume", &two[1]][..], &quick].concat()).exits(0);
    let results = folder.json("out/results.json");
    assert_eq!(results["records"][0]["frames"], 2);
    assert_eq!(results["provenance"]["volumes"][0]["source"], "nrrd-u8.nrrd and 1 more");
}

#[test]
fn a_configuration_may_name_sequences_and_moving_volumes() {
    let folder = Folder::new();
    let samples: Vec<u8> = (0..64).collect();
    for n in 1..=3 {
        folder.write(&format!("step{n}.raw"), &samples);
    }
    let file = "file = \"$CVR_DATA/bonsai.nrrd\"";
    let quick =
        ["run", "x.toml", "--device", "cpu", "--out", "out", "--overwrite", "--set", "scene.size=[8, 8]"];
    for (source, frames) in [
        ("file = \"step*.raw\"\ndims = [4, 4, 4]\ndtype = \"u8\"", 3),
        ("files = [\"step1.raw\", \"step3.raw\"]\ndims = [4, 4, 4]\ndtype = \"u8\"", 2),
        ("generate = \"advected-blobs\"\ndims = [6, 5, 4]\nframes = 4", 4),
    ] {
        assert!(COMPARE.contains(file));
        folder.write("x.toml", COMPARE.replace(file, source));
        folder.cvr(&quick).exits(0);
        assert_eq!(folder.json("out/results.json")["records"][0]["frames"], frames, "{source}");
    }
}
