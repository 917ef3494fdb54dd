//! Predicted frames and lower resolutions, from the configuration to the record and in the commands, with a codec that
//! is only registered here.

use std::process::ExitCode;
use std::sync::Arc;

use clap::Command;
use cvr::commands::{decode, render, run};
use cvr::experiment::files::results::Results;
use cvr::experiment::records::record::{Record, Status};
use cvr::input::Generator;
use cvr::registry::Names;
use cvr_core::codec::{Codec as _, Progress, SettingValue, Settings, encode_file};
use cvr_core::render::{
    Camera, ControlPoint, DecodedFrame, Image, Renderer, TransferFunction, View, upsampled,
};
use cvr_core::volume::{
    BrickSource as _, DenseVolume, Extent, FiniteVolume, FrameIndex, Level, SampleType, Samples, VolumeLayout,
};
use cvr_raycasting::Raycasting;

use super::folder::Folder;
use crate::haar::Haar;

const CONFIG: &str = r##"
[experiment]
name = "levels"
decoded_frames_mb = 1
[[volume]]
name = "v"
generate = "advected-blobs"
dims = [21, 18, 13]
frames = 5
[[codec]]
id = "haar"
group = 3
[pipeline]
renderer = ["raycasting", "slicing"]
geometry = ["planes", "axis", "shells"]
site = ["deferred", "host"]
filter = ["nearest", "linear"]
skipping = [false, true]
resolution = [0, 1]
[[scene]]
name = "front"
size = [24, 24]
frame = [2, 3]
transfer_function = [[0, "#00000000"], [60, "#00000000"], [150, "#ffb04060"], [255, "#ffffffff"]]
"##;

fn names(haar: Haar) -> Names {
    Names::new().unwrap().with_codec(Arc::new(haar)).unwrap()
}

/// The arguments of a command, as a user writes them.
fn args<A: clap::Args + clap::FromArgMatches>(words: &[&str]) -> A {
    let command = A::augment_args(Command::new("cvr"));
    A::from_arg_matches(&command.get_matches_from([&["cvr"], words].concat())).unwrap()
}

/// The result of `cvr run` for the configuration, with the CPU mirror.
fn records(haar: Haar, config: &str, expected: ExitCode) -> (Folder, Vec<Record>) {
    let folder = Folder::new();
    folder.write("levels.toml", config);
    let [config, out] = ["levels.toml", "out"].map(|name| folder.path(name).display().to_string());
    let words = [config.as_str(), "--device", "cpu", "--out", &out];
    let code = run::run_with(&args(&words), &names(haar)).unwrap();
    assert_eq!(format!("{code:?}"), format!("{expected:?}"));
    let records = Results::read(&folder.path("out/results.json")).unwrap().records;
    (folder, records)
}

#[test]
fn a_run_draws_predicted_frames_and_both_resolutions_at_both_sites_by_every_renderer() {
    let (folder, records) = records(Haar::default(), CONFIG, ExitCode::SUCCESS);
    // Renderers × sites × filters × skipping × resolutions.
    assert_eq!(records.len(), 4 * 2 * 2 * 2 * 2);
    for record in &records {
        let name = format!("{} {} {} {}", record.settings, record.renderer, record.site, record.filter);
        assert_eq!((record.status, &record.error), (Status::Ok, &None), "{name}");
        assert!(!record.skipping || record.skipping_mismatches == Some(0), "{name}");
        match record.resolution {
            0 => {
                assert_eq!((record.psnr_db, record.error_bound), (Some(f64::INFINITY), Some(0.0)), "{name}");
                assert_eq!(record.codec_image_psnr_db, Some(f64::INFINITY), "{name}");
            }
            _ => {
                assert_eq!(record.error_bound, None, "the promise is for the full resolution");
                let (voxels, pictures) = (record.psnr_db.unwrap(), record.image_psnr_db.unwrap());
                assert!(voxels > 15.0 && voxels < 60.0, "{name}: {voxels} dB");
                // Another test checks the position of the picture.
                assert!(pictures.is_finite(), "{name}: {pictures} dB");
            }
        }
    }
    assert!(folder.text("out/results.csv").lines().next().unwrap().ends_with(",resolution"));
    assert!(folder.text("out/report.html").contains("(resolution 1)"), "the report tells levels apart");
}

/// The failing twin: frames that are predicted from a wrong frame.
#[test]
fn a_wrong_reference_fails_its_cells() {
    let config = CONFIG
        .replace("renderer = [\"raycasting\", \"slicing\"]", "renderer = \"raycasting\"")
        .replace("geometry = [\"planes\", \"axis\", \"shells\"]\n", "")
        .replace("skipping = [false, true]", "skipping = false")
        .replace("frame = [2, 3]", "frame = 2");
    let predicting = |from: fn(u32) -> u32| {
        let mut haar = Haar::default();
        haar.predicted_from = from;
        haar
    };
    let wrong = predicting(|frame| frame - frame % 3);
    let (_folder, records) = records(wrong, &config, ExitCode::from(1));
    for record in &records {
        let error = record.error.as_deref().unwrap_or_default();
        let broken = error.contains("broke its error bound");
        assert_eq!(broken, record.resolution == 0, "{} {}: {error}", record.site, record.filter);
    }
    // A circle is an error of the stream, reported in words.
    let circle = predicting(|frame| if frame % 3 == 1 { frame + 1 } else { frame - 1 });
    let (_folder, records) = self::records(circle, &config, ExitCode::from(1));
    for record in &records {
        let error = record.error.as_deref().unwrap_or_default();
        assert!(error.contains("frames are predicted in a circle: 1 from 2 from 1"), "{error}");
    }
}

/// Five frames of moving blobs, and a container of them in groups of three.
fn blobs(folder: &Folder) -> FiniteVolume {
    let extent = Extent::new(13, 10, 7).unwrap();
    let dense = cvr::input::generate_frames(Generator::AdvectedBlobs, extent, 5, SampleType::U8, 0).unwrap();
    folder.volume("v.nrrd", &dense);
    let volume = FiniteVolume::new(dense);
    let haar = Haar::default();
    let settings: Settings = [("group".to_owned(), SettingValue::Integer(3))].into_iter().collect();
    let settings = haar.info().complete(&settings).unwrap();
    let replaced = volume.replaced();
    encode_file(&haar, &settings, &volume, replaced, &folder.path("v.cvr"), &Progress::silent()).unwrap();
    volume
}

fn loaded(folder: &Folder, name: &str) -> DenseVolume {
    cvr::input::open(&folder.path(name)).unwrap()
}

/// The lower mean of each pair, along x, then y, then z: the codec's sums, computed in another way.
fn halved(values: &[f32], size: [u32; 3]) -> Vec<f32> {
    let mut values: Vec<i32> = values.iter().map(|v| *v as i32).collect();
    let mut size = size.map(|n| n as usize);
    for axis in 0..3 {
        let mut shorter = size;
        shorter[axis] = size[axis].div_ceil(2);
        let at = |p: [usize; 3]| (p[2] * size[1] + p[1]) * size[0] + p[0];
        let mut means = Vec::new();
        for z in 0..shorter[2] {
            for y in 0..shorter[1] {
                for x in 0..shorter[0] {
                    let (mut p, mut q) = ([x, y, z], [x, y, z]);
                    p[axis] *= 2;
                    q[axis] = (2 * q[axis] + 1).min(size[axis] - 1);
                    means.push((values[at(p)] + values[at(q)]).div_euclid(2));
                }
            }
        }
        (values, size) = (means, shorter);
    }
    values.into_iter().map(|v| v as f32).collect()
}

#[test]
fn decode_writes_predicted_frames_and_a_resolution() {
    let folder = Folder::new();
    let volume = blobs(&folder);
    let decode = |out: &str, more: &[&str]| {
        let [container, out] = ["v.cvr", out].map(|name| folder.path(name).display().to_string());
        let words = [&[container.as_str(), &out, "--decoded-frames-mb", "1"][..], more].concat();
        decode::run_with(&args(&words), &names(Haar::default()))
    };
    decode("all.nrrd", &[]).unwrap();
    let all = loaded(&folder, "all.nrrd");
    assert!(all.samples().as_bytes() == volume.dense().samples().as_bytes(), "lossless");
    decode("low.nrrd", &["--resolution", "1"]).unwrap();
    let low = loaded(&folder, "low.nrrd");
    assert_eq!((low.layout().extent.to_array(), low.layout().frames), ([7, 5, 4], 5));
    assert_eq!(low.layout().spacing, [2.0; 3]);
    // Frames 0 and 3 decode on their own. In others, rounding accumulates to at most one per frame and axis.
    for frame in 0..5 {
        let expected = halved(&volume.dense().frame_values(FrameIndex(frame)), [13, 10, 7]);
        let found = low.frame_values(FrameIndex(frame));
        let off = expected.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off <= 3.0 * (frame % 3) as f32, "frame {frame}: {off}");
    }
    let refused = decode("no.nrrd", &["--resolution", "2"]).unwrap_err().0;
    assert_eq!(refused, "resolution 2: codec haar has resolutions 0 to 1 with these settings");
    assert!(!folder.path("no.nrrd").exists());
}

#[test]
fn render_draws_them_at_both_sites() {
    let folder = Folder::new();
    blobs(&folder);
    let render = |file: &str, out: &str, more: &[&str]| {
        let [file, out] = [file, out].map(|name| folder.path(name).display().to_string());
        let words = [&[file.as_str(), &out, "--device", "cpu", "--size", "40x32"][..], more].concat();
        render::run_with(&args(&words), &names(Haar::default())).unwrap();
        std::fs::read(out).unwrap()
    };
    for renderer in ["raycasting", "slicing", "slicing,geometry=axis"] {
        let scene = ["--frame", "2", "--renderer", renderer];
        let raw = render("v.nrrd", "raw.png", &scene);
        for site in ["deferred", "host"] {
            let at =
                |more: &[&str]| render("v.cvr", "v.png", &[&scene[..], &["--site", site], more].concat());
            assert!(at(&[]) == raw, "{renderer} {site}: lossless, and so the same picture");
            assert!(at(&["--resolution", "1"]) != raw, "{renderer} {site}");
        }
    }
}

/// Waves many voxels long.
fn smooth(size: [u32; 3]) -> FiniteVolume {
    let extent = Extent::try_from(size).unwrap();
    let value = |i: usize| {
        let [x, y, z] = extent.position(i).map(f64::from);
        (128.0 + 120.0 * (0.25 * x).sin() * (0.2 * y).cos() * (0.22 * z + 0.4).sin()).round() as u8
    };
    let samples = Samples::U8((0..extent.voxels() as usize).map(value).collect());
    FiniteVolume::new(DenseVolume::new(VolumeLayout::scalar(extent, SampleType::U8), samples).unwrap())
}

/// Root mean square of the difference of two pictures.
fn distance(a: &Image, b: &Image) -> f64 {
    let squares = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    let sum: f64 = squares.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / (4 * a.pixels().len()) as f64).sqrt()
}

/// A level is drawn at the volume's position, also for odd sizes. The failing twins are far from it: the same frame
/// shifted by half of its voxels, and drawn at the size of its own voxels.
#[test]
fn a_levels_picture_lies_where_the_volumes_does() {
    for size in [[33, 32, 31], [29, 35, 27]] {
        let decoder = Haar::encoded(2, &smooth(size));
        let at = |resolution| {
            let level = Level { resolution, ..Level::FULL };
            DecodedFrame::at(&decoder, FrameIndex::FIRST, level).unwrap()
        };
        let camera = Camera { azimuth: 20.0, elevation: 30.0, ..Camera::default() };
        let point = |value, alpha| ControlPoint { value, rgba: [1.0, 0.7, 0.4, alpha] };
        let haze = TransferFunction::new(vec![point(120.0, 0.0), point(255.0, 0.2)]).unwrap();
        let plain = View { camera, size: [48, 48], ..View::new(haze) };
        let draw = |view: &View, frame: &DecodedFrame| {
            let mut image = Image::new(view.size);
            Raycasting.reference(view, frame, &mut image).unwrap();
            image
        };
        let (full, low) = (at(0), at(1));
        let reference = draw(&plain, &full);
        let coarse = plain.at_resolution(full.layout(), 1, 0.0);
        let own = distance(&draw(&coarse, &low), &reference);
        // For each level voxel, the next voxel above its own: half a level voxel, for even and odd sizes.
        let shifted = {
            let layout = low.layout().clone();
            let moved =
                |p: [u32; 3]| std::array::from_fn(|a| (p[a] + 1).min(layout.extent.to_array()[a] - 1));
            let value = |i: usize| {
                let p = layout.extent.position(i);
                let [here, there] = [p, moved(p)].map(|p| low.values()[layout.extent.index(p)]);
                0.5 * (here + there)
            };
            let values = (0..layout.samples_per_frame() as usize).map(value).collect();
            DecodedFrame::new(layout, values).unwrap()
        };
        let off = distance(&draw(&coarse, &shifted), &reference);
        assert!(off > 2.0 * own, "{size:?}: shifted {off}, as it is {own}");
        // As if the level were a volume of its own, with its own voxel as unit.
        let unscaled = distance(&draw(&plain, &low), &reference);
        assert!(unscaled > 2.0 * own, "{size:?}: unscaled {unscaled}, as it is {own}");
        // And so its voxels.
        let error = |frame: &DecodedFrame| {
            let brought = upsampled(frame, full.layout().extent, (1, 0.0)).unwrap();
            let squares = brought.iter().zip(full.values()).map(|(a, b)| f64::from(a - b).powi(2));
            (squares.sum::<f64>() / brought.len() as f64).sqrt()
        };
        assert!(error(&shifted) > 1.5 * error(&low), "{size:?}: {} and {}", error(&shifted), error(&low));
    }
}

#[test]
fn a_resolution_doubles_the_spacing() {
    let layout = VolumeLayout { spacing: [1.0, 0.5, 3.0], ..smooth([5, 4, 3]).layout().clone() };
    let half = layout.at_resolution(1);
    assert_eq!((half.extent.to_array(), half.spacing), ([3, 2, 2], [2.0, 1.0, 6.0]));
}
