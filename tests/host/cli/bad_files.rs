//! Missing, truncated, false and damaged files: exit code 2, a message that names the file, and no output.

use cvr::input::Generator;
use cvr_core::volume::SampleType;

use super::super::configs::COMPARE;
use super::super::folder::Folder;
use super::super::volumes::computed;

/// An NRRD header of 8-bit samples, raw.
fn header(sizes: &str) -> String {
    format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {sizes}\nencoding: raw\n\n")
}

/// Each command that reads a volume refuses this file. The message names it and contains these words.
fn refused(file: &str, bytes: &[u8], words: &[&str]) {
    let folder = Folder::new();
    folder.write(file, bytes);
    folder.write("x.toml", COMPARE);
    for arguments in [
        &["info", file][..],
        &["encode", file, "out.cvr", "--codec", "raw"],
        &["encode", file, "out.cvr", "--codec", "s3dc"],
        &["render", file, "out.png", "--device", "cpu"],
        &["shader", file],
        &["run", "x.toml", "--device", "cpu", "--volume", file],
    ] {
        let message = folder.cvr(arguments).refused();
        for word in words.iter().chain([&file]) {
            assert!(message.contains(word), "{arguments:?}: no {word:?} in {message}");
        }
        let mut left = ["x.toml", file];
        left.sort_unstable();
        assert_eq!(folder.names(), left, "{arguments:?} left something behind");
    }
}

#[test]
fn truncated_files_are_refused() {
    refused("v.nrrd", &[header("4 4 4").as_bytes(), &[7; 63]].concat(), &["64 bytes", "63"]);
    refused("v.nrrd", b"NRRD0004\ntype: uint8\n", &["dimension"]);
    refused("v.nrrd", b"", &[]);
    let gzip = header("4 4 4").replace("raw", "gzip");
    refused("v.nrrd", &[gzip.as_bytes(), &[0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3, 0x63]].concat(), &["gzip"]);
}

#[test]
fn lying_headers_are_refused() {
    refused("v.nrrd", &[header("400000 400000 4").as_bytes(), &[7; 64]].concat(), &["line 4", "limit"]);
    refused("v.nrrd", &[header("4294967295 4294967295 4294967295").as_bytes(), &[7]].concat(), &["line 4"]);
    refused("v.nrrd", &[header("4 4 4").as_bytes(), &[7; 65]].concat(), &["64", "65"]);
    refused("v.nrrd", &[header("4 4").as_bytes(), &[7; 64]].concat(), &["line 4", "three"]);
    refused("v.nrrd", &[header("4 -4 4").as_bytes(), &[7; 64]].concat(), &["line 4", "-4"]);
    refused("v.nrrd", &[header("4 0 4").as_bytes(), &[7; 64]].concat(), &["line 4"]);
    refused("v.xyz", b"no volume", &["NRRD", "MetaImage"]);
}

#[test]
fn a_headerless_file_of_another_length_is_refused() {
    let folder = Folder::new();
    folder.write("v.raw", [7; 63]);
    let message = folder.cvr(&["info", "v.raw", "--dims", "4x4x4", "--dtype", "u8"]).refused();
    assert!(message.contains("v.raw") && message.contains("64") && message.contains("63"), "{message}");
    folder.cvr(&["info", "v.raw", "--dims", "7x3x3", "--dtype", "u8"]).exits(0);
}

#[test]
fn missing_files_and_folders_are_named() {
    let folder = Folder::new();
    folder.write("x.toml", COMPARE.replace("$CVR_DATA/bonsai.nrrd", "none.nrrd"));
    for arguments in [
        &["info", "none.nrrd"][..],
        &["info", "none.cvr"],
        &["encode", "none.nrrd", "out.cvr", "--codec", "raw"],
        &["decode", "none.cvr", "out.nrrd"],
        &["render", "none.nrrd", "out.png", "--device", "cpu"],
        &["render", "none.cvr", "out.png", "--device", "cpu"],
        &["run", "x.toml", "--device", "cpu"],
        &["run", "x.toml", "--device", "cpu", "--volume", "none.nrrd", "--out", "results"],
    ] {
        let message = folder.cvr(arguments).refused();
        assert!(message.contains("none."), "{arguments:?}: {message}");
        assert_eq!(folder.names(), ["x.toml"], "{arguments:?} left something behind");
    }
    folder.volume("v.nrrd", &computed(Generator::Turbulence, [4; 3], SampleType::U8));
    for arguments in [
        &["encode", "v.nrrd", "no/v.cvr", "--codec", "raw"][..],
        &["render", "v.nrrd", "no/v.png", "--device", "cpu"],
    ] {
        let message = folder.cvr(arguments).refused();
        assert!(message.contains("the folder no does not exist"), "{message}");
    }
}

#[test]
fn an_unset_variable_is_named_with_the_way_out() {
    let folder = Folder::new();
    folder.write("x.toml", COMPARE);
    let message = folder.cvr(&["run", "x.toml", "--device", "cpu"]).refused();
    assert!(message.contains("`bonsai`") && message.contains("CVR_DATA is not set"), "{message}");
    assert!(message.contains("CVR_DATA="), "{message}");
    assert_eq!(folder.names(), ["x.toml"]);
    folder.cvr(&["check-config", "x.toml"]).exits(0);
}

#[test]
fn a_device_that_does_not_exist_is_refused() {
    let folder = Folder::new();
    folder.volume("v.nrrd", &computed(Generator::Turbulence, [4; 3], SampleType::U8));
    let ran = folder.cvr(&["render", "v.nrrd", "v.png", "--device", "no such adapter"]).exits(2);
    assert!(ran.stderr.contains("no such adapter"), "{}", ran.stderr);
    assert_eq!(folder.names(), ["v.nrrd"]);
}

/// With any bit of a container changed, nothing is decoded from it.
#[test]
fn a_damaged_container_is_refused() {
    let folder = Folder::new();
    folder.volume("v.nrrd", &computed(Generator::Turbulence, [9, 8, 7], SampleType::U8));
    folder.cvr(&["encode", "v.nrrd", "v.cvr", "--codec", "s3dc", "--set", "block=4"]).exits(0);
    let whole = folder.read("v.cvr");
    let spec = whole.windows(10).position(|w| w == b"index_bits").unwrap();
    for at in [0, 9, spec, whole.len() - 200, whole.len() - 1] {
        let mut bytes = whole.clone();
        bytes[at] ^= 1;
        folder.write("v.cvr", &bytes);
        damaged(&folder, &format!("bit 0 of byte {at} of {}", whole.len()));
    }
    for length in [0, 7, 100, 2048, whole.len() - 1] {
        folder.write("v.cvr", &whole[..length]);
        damaged(&folder, &format!("{length} bytes of {}", whole.len()));
    }
    folder.write("v.cvr", folder.read("v.nrrd"));
    damaged(&folder, "no container at all");
    folder.write("v.cvr", &whole);
    for arguments in [
        &["info", "v.cvr"][..],
        &["decode", "v.cvr", "out.nrrd"],
        &["render", "v.cvr", "out.png", "--device", "cpu", "--size", "8x8"],
    ] {
        folder.cvr(arguments).exits(0);
    }
}

fn damaged(folder: &Folder, what: &str) {
    for arguments in [
        &["info", "v.cvr"][..],
        &["decode", "v.cvr", "out.nrrd"],
        &["render", "v.cvr", "out.png", "--device", "cpu", "--size", "8x8"],
        &["shader", "v.cvr"],
    ] {
        let ran = folder.cvr(arguments);
        assert_eq!(ran.code, Some(2), "{what}: {arguments:?} gave {ran:?}");
        assert!(ran.stderr.starts_with("error: v.cvr: "), "{what}: {}", ran.stderr);
        assert_eq!(folder.names(), ["v.cvr", "v.nrrd"], "{what}: {arguments:?} left something behind");
    }
}
