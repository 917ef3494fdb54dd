//! Small files that other programs wrote, with the voxels that an independent reader found. Each is read with exactly
//! these voxels, or refused. They lie next to the real volumes, in `$CVR_DATA/../cases/inputs`. Without them a test
//! prints one line.

use std::path::{Path, PathBuf};

use cvr::input::{InputVolume, RawLayout, read};
use cvr_core::volume::{BrickSource as _, Extent, Samples, StoredType};
use sha2::{Digest as _, Sha256};

use super::folder::Folder;

/// One file of the manifest.
#[derive(Clone, serde::Deserialize)]
struct Case {
    file: String,
    args: Vec<String>,
    right: Right,
}

#[derive(Clone, serde::Deserialize)]
struct Right {
    dims: [u32; 3],
    frames: u32,
    channels: u32,
    dtype: String,
    spacing: Option<[f64; 3]>,
    sha256: String,
}

fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("CVR_DATA").map(|data| PathBuf::from(data).join("../cases/inputs"));
    let folder = folder.filter(|f| f.join("MANIFEST.json").is_file());
    if folder.is_none() {
        println!(
            "skipped: no case is read, because CVR_DATA has no ../cases/inputs with a MANIFEST.json beside it"
        );
    }
    folder
}

fn cases(folder: &Path) -> Vec<Case> {
    serde_json::from_slice(&std::fs::read(folder.join("MANIFEST.json")).unwrap()).unwrap()
}

/// The layout that the arguments of a case describe.
fn raw(args: &[String]) -> Option<RawLayout> {
    let value = |name: &str| args.iter().position(|a| a == name).map(|at| args[at + 1].as_str());
    let sizes: Vec<u32> = value("--dims")?.split('x').map(|n| n.parse().unwrap()).collect();
    let extent = Extent::new(sizes[0], sizes[1], sizes[2]).unwrap();
    Some(RawLayout::new(extent, StoredType::from_name(value("--dtype")?).unwrap()))
}

fn little_endian(samples: &Samples) -> Vec<u8> {
    match samples {
        Samples::U8(v) => v.clone(),
        Samples::I8(v) => v.iter().flat_map(|v| v.to_le_bytes()).collect(),
        Samples::U16(v) => v.iter().flat_map(|v| v.to_le_bytes()).collect(),
        Samples::I16(v) => v.iter().flat_map(|v| v.to_le_bytes()).collect(),
        Samples::F32(v) => v.iter().flat_map(|v| v.to_le_bytes()).collect(),
        other => panic!("add the samples {:?} here", other.sample_type()),
    }
}

/// The difference between a volume and the expected one.
fn difference(right: &Right, input: &InputVolume) -> Option<String> {
    let layout = input.volume.layout();
    let found = (layout.extent.to_array(), layout.frames, layout.channels, input.stored.name().to_owned());
    let short = right.dtype.replace("uint", "u").replace("int", "i").replace("float", "f");
    let due = (right.dims, right.frames, right.channels, short);
    if found != due {
        return Some(format!("{found:?} for {due:?}"));
    }
    if let Some(spacing) = right.spacing
        && layout.spacing.iter().zip(spacing).any(|(a, b)| (a - b).abs() > 1e-5 * b.abs())
    {
        return Some(format!("spacing {:?} for {spacing:?}", layout.spacing));
    }
    let digest: String =
        Sha256::digest(little_endian(input.volume.samples())).iter().map(|b| format!("{b:02x}")).collect();
    (digest != right.sha256).then(|| "other voxels".to_owned())
}

fn opened(folder: &Path, case: &Case) -> Result<InputVolume, String> {
    read(&[folder.join(&case.file)], raw(&case.args).as_ref(), None).map_err(|e| e.to_string())
}

#[test]
fn every_file_is_right_or_refused() {
    let Some(folder) = folder() else { return };
    let cases = cases(&folder);
    assert!(cases.len() > 40, "only {} cases are there", cases.len());
    let mut wrong = Vec::new();
    let mut read = Vec::new();
    for case in &cases {
        match opened(&folder, case) {
            Ok(input) => {
                wrong.extend(difference(&case.right, &input).map(|d| format!("{}: {d}", case.file)));
                read.push(case.file.as_str());
            }
            Err(message) => {
                let is_told = message.contains(&case.file) && message.len() < 1000 && message.contains("; ");
                wrong.extend((!is_told).then(|| format!("{}: {message}", case.file)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for file in ["tf_imagej-zyx.tif", "vti_ghost-noactive.vti"] {
        assert!(read.contains(&file), "{file} is refused");
    }
}

/// The comparison notices each thing that it compares.
#[test]
fn the_comparison_can_fail() {
    let Some(folder) = folder() else { return };
    let case = cases(&folder).into_iter().find(|c| c.file == "tf_imagej-zyx.tif").unwrap();
    let input = opened(&folder, &case).unwrap();
    assert_eq!(difference(&case.right, &input), None);
    let changes: [fn(&mut Right); 6] = [
        |right| right.dims = [7, 11, 6],
        |right| right.frames = 2,
        |right| right.channels = 3,
        |right| right.dtype = "int16".to_owned(),
        |right| right.spacing = Some([0.5, 1.25, 2.1]),
        |right| right.sha256 = right.sha256.replace('a', "b"),
    ];
    for change in changes {
        let mut right = case.right.clone();
        change(&mut right);
        assert!(difference(&right, &input).is_some());
    }
}

#[test]
fn what_a_file_promises_and_is_not_read_is_refused() {
    let Some(folder) = folder() else { return };
    for (file, words) in [
        ("18-imagej-hyperstack/zc.tif", "2 channels of 5 slices"),
        ("18-imagej-hyperstack/tz.tif", "3 frames of 5 slices"),
        ("19-imagej-one-ifd/one.tif", "ImageJ promises 5 slices, and 1 page is there"),
        ("tf_single-ifd-imagej.tif", "ImageJ promises 6 slices, and 1 page is there"),
        ("tf_imagej-tzyx.tif", "4 frames of 6 slices"),
        ("tf_imagej-zcyx3.tif", "3 channels of 6 slices"),
        ("tf_ome-czyx.ome.tif", "2 channels of 6 slices"),
        ("tf_pyramid_pages.tif", "a reduced copy"),
        ("tf_volumetric.tif", "`ImageDepth`"),
        ("vti_timesteps.vti", "2 time steps"),
        ("np_rgba.npy", "4 channels"),
    ] {
        let message = read(&[folder.join(file)], None, None).unwrap_err().to_string();
        assert!(message.contains(words) && message.contains(file), "{file}: {message}");
    }
}

#[test]
fn frames_come_in_the_order_of_their_times() {
    let Some(folder) = folder() else { return };
    let out = Folder::new();
    let pattern = folder.join("25-decimal-times/T_*.raw");
    let pattern = pattern.to_str().unwrap();
    out.cvr(&["convert", pattern, "all.raw", "--dims", "24x1x1", "--dtype", "u8"]).exits(0);
    let due: Vec<u8> = (0..8).flat_map(|frame| [frame; 24]).collect();
    assert_eq!(out.read("all.raw"), due);
}

#[test]
fn folders_may_have_brackets_in_their_names() {
    let Some(folder) = folder() else { return };
    let out = Folder::new();
    let path = |name: &str| folder.join("24-brackets").join(name).to_str().unwrap().to_owned();
    let told = out.cvr(&["info", &path("run [2]/step*.npy")]).exits(0).stdout;
    assert!(told.contains("3 frame(s)"), "{told}");
    let raw = ["--dims", "6x5x4", "--dtype", "u8"];
    let told = out.cvr(&[&["info", &path("run [2]/step*.raw")][..], &raw].concat()).exits(0).stdout;
    assert!(told.contains("3 frame(s)"), "{told}");
    out.cvr(&["info", &path("scan[1].npy")]).exits(0);
}
