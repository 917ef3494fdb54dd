//! Transfer functions, from the configuration to the picture: narrow peaks, steps, and refusals.

use std::path::PathBuf;

use cvr::input::write_npy;
use cvr_core::volume::{DenseVolume, Extent, SampleType, Samples, VolumeLayout};

use super::folder::Folder;

/// White at 300 alone.
const PEAK: &str = "0:#ffffff00,290:#ffffff00,300:#ffffffff,310:#ffffff00,65535:#ffffff00";

fn constant(value: u16) -> DenseVolume {
    let layout = VolumeLayout::scalar(Extent::cube(8).unwrap(), SampleType::U16);
    DenseVolume::new(layout, Samples::U16(vec![value; 512])).unwrap()
}

/// The middle of a picture, and its number of pixels that are not black.
fn seen(folder: &Folder, volume: &str, function: &str) -> ([u8; 3], usize) {
    let args =
        ["render", volume, "a.png", "--size", "48x48", "--device", "cpu", "--transfer-function", function];
    folder.cvr(&args).exits(0);
    let picture = image::open(folder.path("a.png")).unwrap().to_rgb8();
    (picture.get_pixel(24, 24).0, picture.pixels().filter(|p| p.0 != [0; 3]).count())
}

#[test]
fn a_narrow_peak_shows_its_value_and_no_other() {
    let folder = Folder::new();
    for (value, white) in [(300, true), (289, false), (290, false), (310, false), (311, false)] {
        write_npy(&folder.path("v.npy"), &constant(value)).unwrap();
        let (middle, shown) = seen(&folder, "v.npy", PEAK);
        if white {
            assert!(middle.iter().all(|c| *c >= 254) && shown > 500, "{value}: {middle:?}, {shown} pixels");
        } else {
            assert_eq!((middle, shown), ([0; 3], 0), "{value}");
        }
    }
    // Half opaque: the sample has the colour of the straight line.
    write_npy(&folder.path("v.npy"), &constant(295)).unwrap();
    let grey = "290:#000000ff,300:#ffffffff,65535:#ffffffff";
    let (middle, _) = seen(&folder, "v.npy", grey);
    assert!(middle.iter().all(|c| (126..=128).contains(c)), "{middle:?}");
}

#[test]
fn the_later_point_of_a_step_holds_at_its_value() {
    let folder = Folder::new();
    let step = "0:#ff0000ff,300:#ff0000ff,300:#0000ffff,65535:#0000ffff";
    for (value, colour) in [(299, [255, 0, 0]), (300, [0, 0, 255])] {
        write_npy(&folder.path("v.npy"), &constant(value)).unwrap();
        let (middle, _) = seen(&folder, "v.npy", step);
        assert!((0..3).all(|c| middle[c].abs_diff(colour[c]) <= 1), "{value}: {middle:?}");
    }
}

#[test]
fn too_many_points_are_refused_with_their_number() {
    let folder = Folder::new();
    write_npy(&folder.path("v.npy"), &constant(300)).unwrap();
    let points = |n: u32| (0..n).map(|i| format!("{i}:#ffffffff")).collect::<Vec<_>>().join(",");
    let (middle, _) = seen(&folder, "v.npy", &points(4096));
    assert!(middle.iter().all(|c| *c >= 254));
    let args = ["render", "v.npy", "b.png", "--device", "cpu", "--transfer-function"];
    let refused = folder.cvr(&[&args[..], &[&points(4097)]].concat()).refused();
    assert!(refused.contains("--transfer-function has 4097") && refused.contains("4096"), "{refused}");
    assert!(!folder.names().contains(&"b.png".to_owned()));
}

#[test]
fn the_case_of_a_narrow_peak() {
    let case = "scenes/27-tf-narrow-peak/u16-300.npy";
    let data = std::env::var_os("CVR_DATA").map(PathBuf::from);
    let file = data.map(|data| data.join("../cases").join(case)).filter(|file| file.is_file());
    let Some(file) = file else {
        println!("skipped: {case} is not drawn, because no folder `cases` lies beside that of CVR_DATA");
        return;
    };
    let (middle, shown) = seen(&Folder::new(), file.canonicalize().unwrap().to_str().unwrap(), PEAK);
    assert!(middle.iter().all(|c| *c >= 254) && shown > 500, "{middle:?}, {shown} pixels");
}
