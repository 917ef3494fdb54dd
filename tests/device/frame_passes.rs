//! Passes of a codec's own on the device, compared with the CPU's values.

use std::sync::Arc;

use cvr::registry::Names;
use cvr::site::target::Target;
use cvr_core::codec::{Decoder as _, Parity, Site};
use cvr_core::conformance;
use cvr_core::render::Filter;
use cvr_core::shader::BindingLimits;
use cvr_core::volume::{BrickSource as _, DenseVolume, FiniteVolume, FrameIndex, Level, SampleType, Samples};
use cvr_core::volume::{Extent, VolumeLayout};
use cvr_engine::testing::test_device;
use cvr_engine::{Device, EngineError, FrameDecoder};

use super::runs::{CONFIG, find, run};
use super::scenes::{checked, deferred, draw, host, textured, view};
use super::subjects::{ODD, decoded, hash, noise};
use crate::haar::{Haar, HaarDecoder, Pass};

const FIRST: FrameIndex = FrameIndex::FIRST;

fn decoder(device: &Device, haar: &HaarDecoder) -> Result<FrameDecoder, EngineError> {
    FrameDecoder::new(device, "haar", haar, FIRST, Level::FULL)
}

/// Texels after two decodes: the rest of the first decode in the scratch buffers must not matter.
fn texels(device: &Device, haar: &HaarDecoder) -> Vec<f32> {
    let decoder = decoder(device, haar).unwrap();
    decoder.decode().unwrap();
    let once = decoder.texture().read(device).unwrap();
    decoder.decode().unwrap();
    let twice = decoder.texture().read(device).unwrap();
    assert!(once == twice, "two decodes differ");
    twice
}

fn parity(haar: &HaarDecoder, texels: &[f32]) -> Parity {
    Parity::compare(haar, haar.frame_decode().unwrap().agreement(), FIRST, &decoded(haar), texels)
}

/// Colours and frames of noise.
fn colours(size: [u32; 3], frames: u32) -> FiniteVolume {
    let layout = VolumeLayout {
        channels: 3,
        frames,
        ..VolumeLayout::scalar(Extent::try_from(size).unwrap(), SampleType::U8)
    };
    let samples = (0..layout.samples() as u32).map(|i| hash([i, 0, 0]) as u8).collect();
    FiniteVolume::new(DenseVolume::new(layout, Samples::U8(samples)).unwrap())
}

#[test]
fn every_texel_is_what_the_cpu_decodes() {
    let Some(device) = test_device("frame_passes::every_texel") else { return };
    for size in [ODD, [1, 1, 1], [5, 1, 130], [130, 2, 2], [64, 64, 1]] {
        for (i, sample) in
            [SampleType::U8, SampleType::I8, SampleType::U16, SampleType::I16].iter().enumerate()
        {
            let haar = Haar::encoded(i as i64 + 1, &noise(size, *sample));
            let texels = texels(device, &haar);
            assert!(texels == decoded(&haar), "{size:?} {sample}: {}", parity(&haar, &texels));
            assert!(texels == original(size, *sample), "{size:?} {sample}: not the volume");
        }
    }
    for (size, levels) in [(ODD, 0), (ODD, 3), ([1, 7, 2], 2)] {
        let haar = Haar::encoded(levels, &colours(size, 1));
        assert!(texels(device, &haar) == decoded(&haar), "{size:?}, colours");
    }
}

fn original(size: [u32; 3], sample: SampleType) -> Vec<f32> {
    let volume = noise(size, sample);
    let mut values = vec![0.0; volume.layout().samples_per_frame() as usize];
    volume.read(FIRST, cvr_core::volume::Region::whole(volume.layout().extent), &mut values).unwrap();
    values
}

/// Every voxel of every frame of every adversarial volume.
#[test]
fn the_battery_runs_the_passes() {
    let Some(device) = test_device("frame_passes::battery") else { return };
    conformance::run(&Haar::default(), Some(device)).assert_ok();
}

#[test]
fn split_buffers_and_slabs_do_not_show() {
    let Some(device) = test_device("frame_passes::split") else { return };
    let haar = Haar::encoded(2, &noise(ODD, SampleType::U16));
    let whole = texels(device, &haar);
    // 5083 words in two parts, three and four.
    for storage_words in [5000, 2000, 1271] {
        let small = device.with_binding_limits(BindingLimits { storage_words, storage_buffers: 8 });
        assert!(texels(&small, &haar) == whole, "in parts of {storage_words} words");
    }
    let small = device.with_binding_limits(BindingLimits { storage_words: 1200, storage_buffers: 8 });
    let error = decoder(&small, &haar).unwrap_err().to_string();
    assert!(error.contains("needs 10 storage buffers") && error.contains("binds 8"), "{error}");
}

/// The failing twin: each pass, off by one, is detected.
#[test]
fn a_wrong_pass_is_caught() {
    let Some(device) = test_device("frame_passes::wrong_pass") else { return };
    let fresh = || Haar::encoded(2, &noise(ODD, SampleType::U8));
    assert!(parity(&fresh(), &texels(device, &fresh())).holds());
    for (pass, from, to) in [
        (Pass::Load, "haar_coefficients(i)", "haar_coefficients(i) + 1u"),
        (Pass::Lift, "difference >> 1u", "difference >> 2u"),
        (Pass::Lift, "(k | 1u) < count", "k + 2u < count"),
        (Pass::Lift, "i32(k & 1u)", "i32(1u - (k & 1u))"),
        (Pass::Row, "difference >> 1u", "(difference + 1) >> 1u"),
        (Pass::Row, "(x | 1u) < haar_length", "(x | 1u) + 2u < haar_length"),
        (Pass::Finish, "haar_sample(i)", "(haar_sample(i) + 1u)"),
    ] {
        let mut haar = fresh();
        haar.passes.change(pass, from, to);
        let parity = parity(&haar, &texels(device, &haar));
        assert!(!parity.holds(), "{pass:?}: `{to}` goes unnoticed");
        // And a run's own comparison.
        let told = checked(device, Site::Deferred, "haar", &haar);
        assert_eq!((told.mismatches, told.largest), (parity.mismatches, parity.largest), "{pass:?}");
        assert!(told.problem.unwrap().starts_with("what the device decoded is not what"), "{pass:?}");
    }
}

#[test]
fn a_broken_pass_is_shown_at_its_own_place() {
    let Some(device) = test_device("frame_passes::broken") else { return };
    for (pass, from, to, place, said) in [
        (Pass::Row, "workgroupBarrier();", "barrier();", "row.wgsl:13:5", "barrier"),
        (Pass::Lift, "i32(k & 1u)", "(k & 1u)", "lift.wgsl:23:", ""),
        (Pass::Load, "haar_set_to(", "haar_put(", "load.wgsl:6:9", "`haar_set_to(i: u32, word: u32)`"),
        (Pass::Finish, "// Integers", "fn finish() {} //", "finish.wgsl:1:4", "does not begin with `haar_`"),
        (
            Pass::Finish,
            "// Integers",
            "@group(1) @binding(7) var<storage> haar_mine: array<u32>; //",
            "finish.wgsl:1:1",
            "a pass has no `@group`",
        ),
    ] {
        let mut haar = Haar::encoded(1, &noise(ODD, SampleType::U8));
        haar.passes.change(pass, from, to);
        let error = decoder(device, &haar).unwrap_err();
        let text = error.to_string();
        assert!(matches!(error, EngineError::Shader(_)), "{text}");
        assert!(text.contains(&format!("tests/haar/{place}")) && text.contains(said), "{to}\n{text}");
    }
    // The device goes on.
    let haar = Haar::encoded(1, &noise(ODD, SampleType::U8));
    assert!(parity(&haar, &texels(device, &haar)).holds());
}

#[test]
fn a_run_draws_a_codec_that_has_no_snippet() {
    let Some(device) = test_device("frame_passes::run") else { return };
    let names = Names::new().unwrap().with_codec(Arc::new(Haar::default())).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let config = CONFIG.replace("id = \"s3dc\"\nblock = 8\nindex_bits = 2", "id = \"haar\"\nlevels = 3");
    let outcome = run(&names, &config, &Target::Device(device.clone()), folder.path());
    let records: Vec<_> = outcome.records.iter().filter(|r| r.codec == "haar").collect();
    // Deferred and host under nearest and linear.
    assert_eq!((records.len(), outcome.failed()), (4, 0));
    for site in ["deferred", "host"] {
        let [nearest, linear] =
            ["nearest", "linear"].map(|filter| find(&outcome.records, "haar", site, filter));
        let on_device = site == "deferred";
        assert_eq!(nearest.parity_mismatches, on_device.then_some(0));
        assert_eq!(nearest.device_decode_ms, linear.device_decode_ms, "decoded once for both");
        assert_eq!(linear.device_decode_ms.is_some_and(|ms| ms > 0.0), on_device);
        let samples = 24 * 24 * 24;
        // Texels, and the coefficients that they can be decoded from again.
        assert_eq!(linear.resident_bytes, Some(if on_device { 5 * samples } else { samples }));
        // Two scratch buffers, rows of 256 bytes on their way to the texture, a uniform.
        let meanwhile = 5 * samples + 8 * samples + 256 * 24 * 24 + 32;
        assert_eq!(linear.device_decode_bytes, on_device.then_some(meanwhile));
        assert_eq!(linear.codec_image_psnr_db, Some(f64::INFINITY), "lossless");
    }
}

/// A codec that decodes wrongly fails each of its cells at the site *deferred*, and no other cell.
#[test]
fn a_run_fails_the_cells_of_a_wrong_pass() {
    let Some(device) = test_device("frame_passes::failing_run") else { return };
    let mut haar = Haar::default();
    haar.passes.change(Pass::Row, "difference >> 1u", "difference >> 2u");
    let names = Names::new().unwrap().with_codec(Arc::new(haar)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let config = CONFIG.replace("id = \"s3dc\"\nblock = 8\nindex_bits = 2", "id = \"haar\"\nlevels = 3");
    let outcome = run(&names, &config, &Target::Device(device.clone()), folder.path());
    assert_eq!(outcome.failed(), 2);
    for filter in ["nearest", "linear"] {
        let record = find(&outcome.records, "haar", "deferred", filter);
        assert!(record.parity_mismatches.is_some_and(|n| n > 0) && record.device_decode_ms.is_some());
        let error = record.error.as_ref().unwrap();
        assert!(error.starts_with("what the device decoded is not what the CPU decodes: "), "{error}");
        assert!(
            error.contains("; the first is voxel ") && error.contains(" where the CPU decodes "),
            "{error}"
        );
        assert_eq!(find(&outcome.records, "haar", "host", filter).error, None);
    }
}

#[test]
fn memory_is_counted_and_scratch_is_not_resident() {
    let Some(device) = test_device("frame_passes::memory") else { return };
    let haar = Haar::encoded(2, &noise(ODD, SampleType::U8));
    let decoder = decoder(device, &haar).unwrap();
    decoder.decode().unwrap();
    let samples = 13 * 17 * 23;
    let texture = decoder.texture().clone();
    assert_eq!((texture.bytes(), texture.resident_bytes()), (samples, samples + 4 * samples));
    assert_eq!(decoder.scratch_bytes(), 2 * 4 * samples);
    // Rows of 256 bytes for the copy, and a uniform.
    let slab = 256 * 17 * 23 + 32;
    assert_eq!(decoder.peak_bytes(), texture.resident_bytes() + decoder.scratch_bytes() + slab);
}

#[test]
fn pictures_are_those_of_host() {
    let Some(device) = test_device("frame_passes::pictures") else { return };
    let volume = textured(ODD, [1.0, 1.5, 0.7], SampleType::U8);
    let haar = Haar::encoded(3, &volume);
    for filter in [Filter::Nearest, Filter::Linear] {
        let view = view(SampleType::U8, [80, 64], filter);
        let (deferred, _) = draw(device, &view, &deferred(device, "haar", &haar));
        let (host, _) = draw(device, &view, &host(device, &haar));
        assert!(deferred.pixels().iter().filter(|p| p[3] > 0.1).count() > 500);
        assert!(deferred == host, "{filter}");
    }
}

#[test]
fn what_the_device_cannot_dispatch_is_refused_with_both_numbers() {
    let Some(device) = test_device("frame_passes::workgroups") else { return };
    let limit = device.capabilities().workgroups_per_axis;
    let mut haar = Haar::encoded(1, &noise([64, 1, 1], SampleType::U8));
    haar.passes.idle_workgroups = limit - 1;
    decoder(device, &haar).unwrap();
    haar.passes.idle_workgroups = limit;
    let error = decoder(device, &haar).unwrap_err();
    assert!(matches!(error, EngineError::TooLarge { .. }), "{error}");
    let expected = format!(
        "pass `haar_finish` needs {} workgroups along one axis, this device offers {limit}",
        u64::from(limit) + 1
    );
    assert_eq!(error.to_string(), expected);
}
