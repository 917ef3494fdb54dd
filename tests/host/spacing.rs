//! Voxels that are not cubes are drawn in their true shape.

use cvr_core::volume::DenseVolume;

use super::folder::Folder;
use super::volumes::{floats, spaced};

/// An opaque cube of 8³ voxels.
fn cube(spacing: [f64; 3]) -> DenseVolume {
    spaced(&floats([8; 3], |_| 1.0), spacing)
}

const SCENE: [&str; 12] = [
    "--device",
    "cpu",
    "--size",
    "128x128",
    "--azimuth",
    "0",
    "--elevation",
    "0",
    "--orthographic",
    "--transfer-function",
    "0:#ffffffff,1:#ffffffff",
    "--filter",
];

/// Width and height of the visible part, in pixels.
fn bounds(folder: &Folder, arguments: &[&str]) -> [u32; 2] {
    folder.cvr(&[arguments, &SCENE, &["nearest"]].concat()).exits(0);
    let picture = image::open(folder.path("v.png")).unwrap().to_rgb8();
    let seen: Vec<(u32, u32)> =
        picture.enumerate_pixels().filter(|(_, _, p)| p.0[0] > 127).map(|(x, y, _)| (x, y)).collect();
    let span = |of: fn(&(u32, u32)) -> u32| {
        let (low, high) = (seen.iter().map(of).min().unwrap(), seen.iter().map(of).max().unwrap());
        high - low + 1
    };
    [span(|p| p.0), span(|p| p.1)]
}

/// Height over width.
fn ratio([width, height]: [u32; 2]) -> f64 {
    assert!(width > 10 && height > 10, "{width} × {height} pixels are too few to measure");
    f64::from(height) / f64::from(width)
}

#[test]
fn a_volume_is_as_tall_as_its_spacing_says() {
    for (spacing, expected) in
        [([1.0, 1.0, 4.0], 4.0), ([1.0; 3], 1.0), ([4.0, 1.0, 2.0], 0.5), ([0.3, 0.3, 0.6], 2.0)]
    {
        let folder = Folder::new();
        folder.volume("v.nrrd", &cube(spacing));
        let measured = ratio(bounds(&folder, &["render", "v.nrrd", "v.png"]));
        assert!((measured / expected - 1.0).abs() < 0.08, "{spacing:?}: {measured}");
        folder.cvr(&["encode", "v.nrrd", "v.cvr", "--codec", "s3dc"]).exits(0);
        assert_eq!(ratio(bounds(&folder, &["render", "v.cvr", "v.png"])), measured, "through a container");
    }
}

#[test]
fn the_spacing_of_a_headerless_file_counts() {
    let folder = Folder::new();
    folder.write("v.raw", 1.0_f32.to_le_bytes().repeat(512));
    let layout = ["render", "v.raw", "v.png", "--dims", "8x8x8", "--dtype", "f32"];
    let cube = ratio(bounds(&folder, &layout));
    let tall = ratio(bounds(&folder, &[&layout[..], &["--spacing", "1,1,4"]].concat()));
    assert!((cube - 1.0).abs() < 0.05 && (tall / 4.0 - 1.0).abs() < 0.08, "{cube}, {tall}");
}
