//! Formats that are not text: lies, cuts and damage. No panic, and nothing is read that is not there.

use std::path::PathBuf;

use cvr_core::volume::BrickSource as _;
use proptest::prelude::*;

use super::Folder;
use super::lies;
use crate::input::open;

#[test]
fn every_lie_is_refused_with_its_place_and_a_way_out() {
    let folder = Folder::new();
    let mut wrong = Vec::new();
    for lie in lies::all() {
        let path = folder.write(lie.name, "", &lie.bytes);
        match open(&path) {
            Ok(volume) => wrong.push(format!("{}: read as {}", lie.name, volume.layout().extent)),
            Err(error) => {
                let message = error.to_string().replace(&format!("{}/", folder.0.path().display()), "");
                let is_right = message.starts_with(lie.name) && lie.words.iter().all(|w| message.contains(w));
                if !is_right || message.len() > 600 {
                    wrong.push(format!("{:?} in {message}", lie.words));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn foreign() -> Vec<(String, Vec<u8>)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/input/tests/foreign");
    let mut files: Vec<(String, Vec<u8>)> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.is_file() && p.extension().is_some_and(|e| e != "py"))
        .map(|p| (p.file_name().unwrap().to_str().unwrap().to_owned(), std::fs::read(p).unwrap()))
        .collect();
    let png = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/input/tests/foreign/png-u16/8.png");
    files.push(("8.png".to_owned(), std::fs::read(png).unwrap()));
    files.sort();
    files
}

/// Cut anywhere, a file is refused, unless all that was cut off is what no reader needs.
#[test]
fn cut_files_are_refused() {
    let folder = Folder::new();
    for (name, bytes) in foreign() {
        let whole = open(&folder.write(&name, "", &bytes)).unwrap();
        for cut in (0..16).map(|i| bytes.len() * i / 16).chain([bytes.len() - 1]) {
            if let Ok(volume) = open(&folder.write(&name, "", &bytes[..cut])) {
                let trailer = name.starts_with("vti") || name.starts_with("tiff");
                assert!(trailer && volume == whole, "{name} cut to {cut} of {} bytes is read", bytes.len());
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    /// Good files of every format with some bytes replaced, most of them in the header.
    #[test]
    fn any_damage(
        file in any::<prop::sample::Index>(),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), any::<bool>()), 1..6),
    ) {
        let files = FILES.with(Clone::clone);
        let (name, bytes) = file.get(&files);
        let mut bytes = bytes.clone();
        for (at, byte, in_header) in damage {
            let end = if in_header { bytes.len().min(400) } else { bytes.len() };
            bytes[at.index(end)] = byte;
        }
        let folder = Folder::new();
        let _ = open(&folder.write(name, "", &bytes));
    }

    /// Any dimensions in a NIfTI header: read only if the file holds them.
    #[test]
    fn any_dimensions(dim in prop::collection::vec(any::<i16>(), 8), datatype in any::<i16>()) {
        let folder = Folder::new();
        let bytes = lies::nifti(&dim, datatype);
        prop_assert!(open(&folder.write("v.nii", "", &bytes)).is_err());
    }

    /// Any shape in an NPY header.
    #[test]
    fn any_shape(shape in prop::collection::vec(any::<u64>(), 0..6), descr in "['<>|=]{0,2}[uifOb][0-9]{0,2}'?") {
        let shape: Vec<String> = shape.iter().map(u64::to_string).collect();
        let dictionary =
            format!("{{'descr': {descr}, 'fortran_order': True, 'shape': ({}), }}", shape.join(", "));
        let folder = Folder::new();
        prop_assert!(open(&folder.write("v.npy", "", &lies::npy(&dictionary, None))).is_err());
    }
}

thread_local! {
    static FILES: Vec<(String, Vec<u8>)> = foreign();
}
