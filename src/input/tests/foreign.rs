//! Files written by other software (`foreign/write.py` says which), whose every sample is known from where it lies.

use std::path::PathBuf;

use cvr_core::volume::{BrickSource as _, SampleType, Samples, StoredType};

use crate::input::{InputVolume, read};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/input/tests/foreign")
}

/// Meaning of a name: number type, channels, frames.
fn named(name: &str) -> (StoredType, u32, u32) {
    let stem = name.split('.').next().unwrap();
    let words: Vec<&str> = stem.split('-').collect();
    let stored = words.iter().find_map(|w| StoredType::from_name(w)).unwrap();
    let has = |word| words.contains(&word);
    (stored, if has("rgb") { 3 } else { 1 }, if has("t") { 2 } else { 1 })
}

fn expected(stored: StoredType, [x, y, z]: [u32; 3], channel: u32, frame: u32) -> f32 {
    let n = (x + 5 * y + 7 * z + 11 * channel + 13 * frame) as f32;
    match stored {
        StoredType::F32 | StoredType::F64 => n + 0.25,
        StoredType::I8 | StoredType::I16 | StoredType::I32 | StoredType::I64 => n - 40.0,
        _ => n,
    }
}

/// How the volume differs from what it should be, if it does.
fn difference(name: &str, input: &InputVolume) -> Option<String> {
    let (stored, channels, frames) = named(name);
    let layout = input.volume.layout();
    let facts = (layout.extent.to_array(), layout.channels, layout.frames, input.stored, input.rounded);
    if facts != ([5, 4, 3], channels, frames, stored, 0) {
        return Some(format!("{facts:?}"));
    }
    let format = name.split('-').next().unwrap();
    let has_spacing = ["nifti", "vti", "nrrd", "metaimage"].contains(&format);
    let spacing = if has_spacing { [0.5, 1.25, 2.0] } else { [1.0; 3] };
    if layout.spacing != spacing {
        return Some(format!("spacing {:?}", layout.spacing));
    }
    for i in 0..input.volume.samples().len() {
        let mut rest = i as u32;
        let [c, x, y, z, t] = [channels, 5, 4, 3, frames].map(|n| {
            let at = rest % n;
            rest /= n;
            at
        });
        let (found, due) = (input.volume.samples().get(i), expected(stored, [x, y, z], c, t));
        if found != due {
            return Some(format!("sample {x} {y} {z}, channel {c}, frame {t} is {found}, not {due}"));
        }
    }
    None
}

#[test]
fn every_file_holds_what_its_name_says() {
    let mut files = 0;
    let mut wrong = Vec::new();
    for entry in std::fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if name == "write.py" || name == "scaled-i16.nii" {
            continue;
        }
        files += 1;
        match read(std::slice::from_ref(&path), None, None) {
            Ok(input) => wrong.extend(difference(&name, &input).map(|d| format!("{name}: {d}"))),
            Err(error) => wrong.push(error.to_string()),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(files > 90, "only {files} files are there");
}

/// The comparison above notices a sample, a type, a shape and a spacing that is off.
#[test]
fn the_comparison_can_fail() {
    let read = |name: &str| read(&[folder().join(name)], None, None).unwrap();
    let volume = read("npy-c-i16.npy");
    assert_eq!(difference("npy-c-i16.npy", &volume), None);
    for name in ["npy-c-u16.npy", "npy-c-i16-t.npy", "npy-c-i16-rgb.npy", "nrrd-i16.nrrd"] {
        assert!(difference(name, &volume).is_some(), "{name}");
    }
    let mut other = read("npy-c-f32.npy");
    other.rounded = 1;
    assert!(difference("npy-c-f32.npy", &other).is_some());
}

/// Scaled NIfTI becomes single precision; what the file stores is 16 bits.
#[test]
fn scaling_is_applied() {
    let input = read(&[folder().join("scaled-i16.nii")], None, None).unwrap();
    assert_eq!((input.stored, input.rounded), (StoredType::I16, 0));
    assert_eq!(input.volume.layout().sample, SampleType::F32);
    let due = (0..60).map(|i| expected(StoredType::I16, [i % 5, i / 5 % 4, i / 20], 0, 0) / 2.0 - 3.0);
    assert_eq!(input.volume.samples(), &Samples::F32(due.collect()));
}
