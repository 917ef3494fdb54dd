//! Predicted frames and lower resolutions on the device: the references that passes read, and pictures of levels at the
//! volume's size.

use std::sync::Arc;

use cvr::registry::Names;
use cvr::site::coded::CodedFrame;
use cvr::site::picture::VoxelSource;
use cvr::site::target::Target;
use cvr_core::codec::{Decoder, FrameStore, Parity, Settings, Site, deferred_agreement};
use cvr_core::conformance;
use cvr_core::render::{Camera, DecodedFrame, Filter, Image, Light, Renderer, View};
use cvr_core::shader::TextureSampling;
use cvr_core::volume::{
    DenseVolume, Extent, FiniteVolume, FrameIndex, Level, SampleType, Samples, VolumeLayout,
};
use cvr_engine::testing::test_device;
use cvr_engine::{Device, VolumeTexture};
use cvr_raycasting::Raycasting;
use cvr_slicing::{Geometry, Slicing};

use super::runs::run;
use super::scenes::{clipped, lit, rule, sums_single, textured, view};
use super::subjects::{ODD, hash};
use crate::haar::{Haar, HaarDecoder, Pass};

/// Frames of noise that change a little from one to the next.
fn frames(size: [u32; 3], channels: u32, frames: u32) -> FiniteVolume {
    let extent = Extent::try_from(size).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, SampleType::U8) };
    let n = layout.samples_per_frame();
    let sample = |i: u64| (hash([(i % n) as u32, 0, 0]) >> 8) as u8 ^ (hash([i as u32, 1, 0]) as u8 & 7);
    let samples = (0..layout.samples()).map(sample).collect();
    FiniteVolume::new(DenseVolume::new(layout, Samples::U8(samples)).unwrap())
}

fn groups(size: [u32; 3], channels: u32) -> HaarDecoder {
    Haar::in_groups(2, 3, &frames(size, channels, 5))
}

/// Every frame and resolution as the device rebuilds it, against the CPU.
fn parities(device: &Device, decoder: HaarDecoder) -> Vec<(u32, u8, Parity)> {
    let store = FrameStore::open(Arc::new(decoder), u64::MAX);
    let decoder = store.as_ref();
    let mut all = Vec::new();
    for resolution in [0, 1] {
        let level = Level { resolution, ..Level::FULL };
        for frame in (0..decoder.layout().frames).map(FrameIndex) {
            let cpu = DecodedFrame::at(decoder, frame, level).unwrap();
            let (texture, _) = VolumeTexture::decode(device, "haar", decoder, frame, level).unwrap();
            assert_eq!(texture.layout(), cpu.layout());
            let texels = texture.read(device).unwrap();
            let agreement = deferred_agreement(decoder).unwrap();
            let parity = Parity::compare_at(decoder, agreement, (frame, level), cpu.values(), &texels);
            all.push((frame.0, resolution, parity));
        }
    }
    all
}

#[test]
fn predicted_frames_of_both_resolutions_are_what_the_cpu_decodes() {
    let Some(device) = test_device("levels::parity") else { return };
    for (size, channels) in [(ODD, 1), ([9, 4, 5], 3), ([1, 1, 1], 1), ([6, 1, 2], 1)] {
        for (frame, resolution, parity) in parities(device, groups(size, channels)) {
            assert!(parity.holds(), "{size:?}, frame {frame}, resolution {resolution}: {parity}");
        }
    }
}

/// The failing twins: another sample of the reference, no reference, and another coefficient of the lower resolution.
#[test]
fn a_wrong_reference_or_coefficient_is_caught_where_it_is_read() {
    let Some(device) = test_device("levels::twins") else { return };
    let wrong = |pass, from, to| {
        let mut decoder = groups(ODD, 1);
        decoder.passes.change(pass, from, to);
        parities(device, decoder)
    };
    for to in ["haar_reference(i ^ 1u)", "(haar_reference(i) & 0u)"] {
        for (frame, resolution, parity) in wrong(Pass::Add, "haar_reference(i)", to) {
            let predicted = frame % 3 > 0;
            assert_eq!(parity.holds(), !predicted, "{to}, frame {frame}, resolution {resolution}");
        }
    }
    for (frame, resolution, parity) in wrong(Pass::Low, "(at.z * haar_stored.y", "(at.z * haar_extent.y") {
        assert_eq!(parity.holds(), resolution == 0, "frame {frame}, resolution {resolution}");
    }
}

#[test]
fn the_battery_runs_predicted_frames() {
    let Some(device) = test_device("levels::battery") else { return };
    let settings: Settings = [("group".to_owned(), "2".into())].into_iter().collect();
    conformance::run_with(&Haar::default(), &[settings], Some(device)).assert_ok();
}

fn slicing(geometry: Geometry) -> Slicing {
    Slicing { geometry, ..Slicing::default() }
}

/// A picture of the lower resolution at a site, and its filtering unit.
fn draw(
    target: &Target,
    renderer: &dyn Renderer,
    view: &View,
    decoder: &HaarDecoder,
    deferred: bool,
) -> (Image, TextureSampling) {
    let key = (FrameIndex::FIRST, Level { resolution: 1, ..Level::FULL });
    let coded = CodedFrame { codec: "haar", decoder, key };
    let decoded = || DecodedFrame::at(decoder, key.0, key.1).map_err(|e| e.to_string());
    let site = if deferred { Site::Deferred } else { Site::Host };
    let source = VoxelSource::prepare(target, site, coded, &decoded).unwrap();
    let picture = target.picture(renderer, view, &source).unwrap();
    let image = picture.image().unwrap();
    let hardware = picture.filtering() == "hardware";
    (image, if hardware { TextureSampling::Hardware } else { TextureSampling::Manual })
}

/// For every renderer and both filters, lit and clipped, of a volume of odd sizes whose resolution extends beyond it.
#[test]
fn pictures_of_a_resolution_are_those_of_the_mirror() {
    let Some(device) = test_device("levels::pictures") else { return };
    let (device, mirror) = (Target::Device(device.clone()), Target::Cpu { reason: None });
    let Target::Device(on) = &device else { return };
    let decoder = Haar::encoded(2, &textured(ODD, [1.0, 1.5, 0.7], SampleType::U8));
    let renderers: [&dyn Renderer; 4] =
        [&Raycasting, &slicing(Geometry::Planes), &slicing(Geometry::Axis), &slicing(Geometry::Shells)];
    for (number, renderer) in renderers.into_iter().enumerate() {
        if number > 0 && !sums_single(on, "levels::pictures") {
            continue;
        }
        for filter in [Filter::Nearest, Filter::Linear] {
            let plain = view(SampleType::U8, [48, 40], filter);
            let views = [plain.clone(), lit(clipped(plain.clone()), Light::Fixed)];
            for (kind, view) in views.into_iter().enumerate() {
                let (expected, _) = draw(&mirror, renderer, &view, &decoder, false);
                for deferred in [false, true] {
                    let (found, sampling) = draw(&device, renderer, &view, &decoder, deferred);
                    let name = format!("renderer {number}, {filter}, view {kind}, deferred {deferred}");
                    let agreed =
                        rule(sampling).check(&expected, &found).unwrap_or_else(|e| panic!("{name}: {e}"));
                    assert!(agreed.visible_pixels > 100, "{name}");
                    // The failing twin: a slightly larger picture, as if the resolution's own voxels set the size.
                    let camera = Camera { zoom: 1.08 * view.camera.zoom, ..view.camera };
                    let (larger, sampling) =
                        draw(&device, renderer, &View { camera, ..view.clone() }, &decoder, deferred);
                    let told = rule(sampling).check(&expected, &larger);
                    assert!(told.is_err(), "{name}: a larger picture goes unnoticed");
                }
            }
        }
    }
}

#[test]
fn a_run_draws_predicted_frames_and_both_resolutions_on_the_device() {
    let Some(device) = test_device("levels::run") else { return };
    const CONFIG: &str = r##"
[experiment]
name = "levels"
[[volume]]
name = "v"
generate = "advected-blobs"
dims = [21, 18, 13]
frames = 3
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
frame = 2
transfer_function = [[0, "#00000000"], [60, "#00000000"], [150, "#ffb04060"], [255, "#ffffffff"]]
"##;
    let names = Names::new().unwrap().with_codec(Arc::new(Haar::default())).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(&names, CONFIG, &Target::Device(device.clone()), folder.path());
    assert_eq!(outcome.records.len(), 4 * 2 * 2 * 2 * 2);
    for record in &outcome.records {
        let name = format!("{} {} {} {}", record.renderer, record.site, record.filter, record.resolution);
        assert_eq!(record.error, None, "{name}");
        let on_device = record.site == "deferred";
        assert_eq!(record.parity_mismatches, on_device.then_some(0), "{name}");
        assert!(!record.skipping || record.skipping_mismatches == Some(0), "{name}");
        let voxels = if record.resolution == 0 { 21 * 18 * 13 } else { 11 * 9 * 7 };
        // Texels in single precision; the coefficients, and the reference of this frame.
        let stream = 4 * (21 * 18 * 13 + voxels);
        assert_eq!(record.resident_bytes, Some(4 * voxels + if on_device { stream } else { 0 }), "{name}");
        match record.resolution {
            // Lossless, but with another texel format than raw.
            0 => assert!(
                record.codec_image_psnr_db.is_some_and(|psnr| psnr > 50.0),
                "{name}: {:?}",
                record.codec_image_psnr_db
            ),
            _ => assert!(record.image_psnr_db.is_some_and(f64::is_finite), "{name}"),
        }
    }
}

/// A chain decodes on the device although only one frame is kept.
#[test]
fn what_is_kept_does_not_decide_what_is_decoded() {
    let Some(device) = test_device("levels::kept") else { return };
    let decode = |bound_bytes| {
        let store = FrameStore::open(Arc::new(groups(ODD, 1)), bound_bytes);
        let decoder: &dyn Decoder = store.as_ref();
        let (texture, _) =
            VolumeTexture::decode(device, "haar", decoder, FrameIndex(2), Level::FULL).unwrap();
        texture.read(device).unwrap()
    };
    assert!(decode(0) == decode(u64::MAX));
}
