//! Several files, one volume: patterns, lists, folders.

use std::path::PathBuf;

use cvr_core::volume::{BrickSource as _, Extent, SampleType, Samples, StoredType};

use super::{Folder, small};
use crate::input::{InputError, InputVolume, RawLayout, open, read, write_nrrd};

fn raw() -> RawLayout {
    RawLayout::new(Extent::new(2, 1, 1).unwrap(), StoredType::U8)
}

fn message(folder: &Folder, result: Result<InputVolume, InputError>) -> String {
    folder.message(result.map(|input| input.volume))
}

/// A folder with the frames 1, 2, 9, 10 and 11, written in another order.
fn frames() -> Folder {
    let folder = Folder::new();
    for n in [10, 2, 1, 11, 9_u8] {
        folder.write(&format!("step{n}.raw"), "", &[n, n + 100]);
    }
    folder.write("notes.txt", "no frame", &[]);
    folder
}

#[test]
fn a_pattern_is_its_files_in_the_order_of_their_numbers() {
    let folder = frames();
    let input = read(&[folder.path("step*.raw")], Some(&raw()), None).unwrap();
    assert_eq!(input.volume.layout().frames, 5);
    let due = [1, 2, 9, 10, 11].into_iter().flat_map(|n| [n, n + 100]).collect();
    assert_eq!(input.volume.samples(), &Samples::U8(due));
    let input = read(&[folder.path("step?.raw"), folder.path("step11.raw")], Some(&raw()), None).unwrap();
    assert_eq!(input.volume.samples(), &Samples::U8(vec![1, 101, 2, 102, 9, 109, 11, 111]));
    assert_eq!(
        message(&folder, read(&[folder.path("frame*.raw")], Some(&raw()), None)),
        "frame*.raw: no file matches the pattern; correct it"
    );
    assert!(
        message(&folder, read(&[folder.path("step[.raw")], Some(&raw()), None))
            .contains("this is no pattern")
    );
}

#[test]
fn frames_come_in_the_order_of_decimals() {
    let folder = Folder::new();
    let times = ["0", "0.05", "0.1", "0.25", "0.5", "1", "1.5", "10"];
    for (n, time) in (0_u8..).zip(times) {
        folder.write(&format!("T_{time}.raw"), "", &[n, n]);
    }
    let due = Samples::U8((0..8).flat_map(|n| [n, n]).collect());
    for path in [folder.path("T_*.raw"), folder.0.path().to_owned()] {
        assert_eq!(read(&[path], Some(&raw()), None).unwrap().volume.samples(), &due);
    }
}

/// The exact name of an existing folder or file is not a pattern.
#[test]
fn brackets_in_names_are_no_patterns() {
    let folder = Folder::new();
    let run = folder.path("run [2]/a*b");
    std::fs::create_dir_all(&run).unwrap();
    for n in [5, 0, 10_u8] {
        std::fs::write(run.join(format!("step{n}.raw")), [n, n]).unwrap();
    }
    std::fs::write(run.join("scan[1].raw"), [77, 77]).unwrap();
    std::fs::write(run.join("scan1.raw"), [1, 1]).unwrap();
    let samples = |path: &str| match read(&[folder.path(path)], Some(&raw()), None).unwrap().volume.samples()
    {
        Samples::U8(samples) => samples.iter().copied().step_by(2).collect::<Vec<u8>>(),
        _ => panic!("8 bits"),
    };
    let steps = [0, 5, 10];
    for pattern in [
        "run [2]/a*b/step*.raw",
        "run*/a*b/step*.raw",
        "run [2]/a?b/step*.raw",
        "r*/*/step[0-9]*.raw",
        "**/step*.raw",
    ] {
        assert_eq!(samples(pattern), steps, "{pattern}");
    }
    assert_eq!(samples("run [2]/a*b/scan[1].raw"), [77]);
    assert_eq!(samples("run [2]/a*b/scan[12].raw"), [1]);
    let gone = message(&folder, read(&[folder.path("run [3]/step*.raw")], Some(&raw()), None));
    assert!(gone.contains("no file matches the pattern"), "{gone}");
}

#[test]
fn a_list_keeps_its_order() {
    let folder = frames();
    let files: Vec<PathBuf> = ["step10.raw", "step1.raw", "step10.raw"].map(|n| folder.path(n)).to_vec();
    let input = read(&files, Some(&raw()), None).unwrap();
    assert_eq!(input.volume.samples(), &Samples::U8(vec![10, 110, 1, 101, 10, 110]));
}

#[test]
fn a_folder_of_headerless_files_is_a_sequence() {
    let folder = frames();
    let refusal = message(&folder, read(&[folder.0.path().to_owned()], Some(&raw()), None));
    assert!(refusal.contains("notes.txt: 2×1×1 voxels of u8 take 2 bytes, but 8 are there"), "{refusal}");
    std::fs::remove_file(folder.path("notes.txt")).unwrap();
    folder.write(".hidden", "", &[1; 9]);
    let input = read(&[folder.0.path().to_owned()], Some(&raw()), None).unwrap();
    assert_eq!(input.volume.layout().frames, 5);
    let empty = Folder::new();
    let refusal = read(&[empty.0.path().to_owned()], Some(&raw()), None).unwrap_err().to_string();
    assert!(refusal.ends_with("the folder holds no files; give one with a file per frame"), "{refusal}");
}

/// A file that has the pattern's very name is that file.
#[test]
fn a_name_with_a_wildcard_may_be_a_file() {
    let folder = frames();
    folder.write("step*.raw", "", &[7, 8]);
    let input = read(&[folder.path("step*.raw")], Some(&raw()), None).unwrap();
    assert_eq!(input.volume.samples(), &Samples::U8(vec![7, 8]));
}

#[test]
fn frames_of_files_with_several_follow_each_other() {
    let folder = Folder::new();
    let npy = |name: &str, shape: &str, bytes: &[u8]| {
        let dictionary = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': {shape}, }}\n");
        let magic = [b"\x93NUMPY\x01\x00", &(dictionary.len() as u16).to_le_bytes()[..]].concat();
        folder.write(name, "", &[&magic, dictionary.as_bytes(), bytes].concat())
    };
    let files = [npy("a.npy", "(2, 1, 1, 2, 1)", &[1, 2, 3, 4]), npy("b.npy", "(1, 1, 2)", &[5, 6])];
    let input = read(&files, None, None).unwrap();
    assert_eq!(input.volume.layout().frames, 3);
    assert_eq!(input.volume.samples(), &Samples::U8(vec![1, 2, 3, 4, 5, 6]));
}

#[test]
fn frames_must_be_alike() {
    let folder = Folder::new();
    let one = small(SampleType::U8, [1.0; 3]);
    write_nrrd(&folder.path("a.nrrd"), &one).unwrap();
    write_nrrd(&folder.path("b.nrrd"), &small(SampleType::I8, [1.0; 3])).unwrap();
    write_nrrd(&folder.path("c.nrrd"), &small(SampleType::U8, [1.0, 1.0, 2.0])).unwrap();
    for other in ["b.nrrd", "c.nrrd"] {
        let refusal = message(&folder, read(&[folder.path("a.nrrd"), folder.path(other)], None, None));
        assert!(refusal.starts_with(&format!("{other}: a frame of 3×4×2 scalars of ")), "{refusal}");
        assert!(refusal.contains("after a.nrrd of ") || refusal.contains("/a.nrrd of "), "{refusal}");
    }
    let gone = message(&folder, read(&[folder.path("a.nrrd"), folder.path("gone.nrrd")], None, None));
    assert!(gone.starts_with("gone.nrrd: cannot open the file"), "{gone}");
    assert!(read(&[], None, None).is_err());
}

#[test]
fn a_given_spacing_stands_in_for_the_files() {
    let folder = Folder::new();
    let path = folder.path("a.nrrd");
    write_nrrd(&path, &small(SampleType::U8, [1.0; 3])).unwrap();
    let input = read(std::slice::from_ref(&path), None, Some([0.5, 1.0, 2.0])).unwrap();
    assert_eq!(input.volume.layout().spacing, [0.5, 1.0, 2.0]);
    assert_eq!(input.volume.samples(), open(&path).unwrap().samples());
    let refusal = message(&folder, read(&[path], None, Some([0.0, 1.0, 1.0])));
    assert!(refusal.contains("correct the spacing that was given"), "{refusal}");
}

#[test]
fn slices_of_a_folder_must_be_alike() {
    let foreign = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/input/tests/foreign");
    let folder = Folder::new();
    let copy = |from: &str, to: &str| std::fs::copy(foreign.join(from), folder.path(to)).unwrap();
    copy("png-u8/slice8.png", "1.png");
    copy("png-u16/8.png", "2.png");
    assert_eq!(
        folder.message(open(folder.0.path())),
        "2.png: a slice of 5×4 pixels of gray u16 after one of 5×4 pixels of gray u8; \
         all slices of a volume are alike: remove what does not belong to it"
    );
    std::fs::remove_file(folder.path("2.png")).unwrap();
    assert_eq!(open(folder.0.path()).unwrap().layout().extent.to_array(), [5, 4, 1]);
    copy("tiff-plain-u8.tif", "3.tif");
    assert!(folder.message(open(folder.0.path())).contains("holds TIFF files and PNG files"));
    std::fs::remove_file(folder.path("1.png")).unwrap();
    folder.write("readme.txt", "passed over", &[]);
    assert_eq!(
        open(folder.0.path()).unwrap().layout().extent.to_array(),
        [5, 4, 3],
        "pages of a file in a folder"
    );
}
