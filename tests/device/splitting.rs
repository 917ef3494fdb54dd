//! A codec's buffers over several bindings: snippet, picture and dump are unaffected.

use cvr_core::codec::{Parity, VoxelDump};
use cvr_core::render::{Filter, Image, Renderer};
use cvr_core::shader::BindingLimits;
use cvr_core::volume::{FrameIndex, SampleType};
use cvr_engine::testing::test_device;
use cvr_engine::{Device, DrawSource, Drawing};
use cvr_raycasting::Raycasting;

use super::scenes::{inline, view};
use super::subjects::{ODD, codec, decoded, encoded, noise, settings};

fn small(device: &Device, storage_words: u64) -> Device {
    device.with_binding_limits(BindingLimits { storage_words, storage_buffers: 8 })
}

fn draw(device: &Device, source: &DrawSource<'_>) -> (Image, String) {
    let view = view(SampleType::U16, [40, 30], Filter::Linear);
    let plan = Raycasting.plan(&view, &source.layout()).unwrap();
    let drawing = Drawing::new(device, &plan, source, view.filter).unwrap();
    drawing.draw_timed().unwrap();
    (drawing.read_image().unwrap(), drawing.wgsl().to_owned())
}

#[test]
fn every_voxel_decodes_from_split_buffers() {
    let Some(device) = test_device("splitting::every_voxel") else { return };
    // The parts end within rows and blocks. s3dc's Index volume has 1564 words, raw's samples have 2542.
    for (id, pairs, words, last_part) in [
        ("raw", &[("bits", "native")][..], 450, "raw_samples_part5["),
        ("s3dc", &[("block", "4"), ("index_bits", "4")], 397, "s3dc_index_part1["),
        ("s3dc", &[("block", "2"), ("index_bits", "8")], 401, "s3dc_index_part3["),
    ] {
        let codec = codec(id);
        let decoder = encoded(codec.as_ref(), &settings(pairs), &noise(ODD, SampleType::U16));
        let device = small(device, words);
        let (_, wgsl) = draw(&device, &inline(id, decoder.as_ref()));
        assert!(wgsl.contains(last_part), "{id}: not split as this test means it\n{wgsl}");
        let agreement = decoder.shader().unwrap().agreement();
        for use_cell in [false, true].into_iter().take(1 + usize::from(codec.info().fetch_cell)) {
            let dump = device.dump(id, decoder.as_ref(), FrameIndex::FIRST, use_cell).unwrap();
            let cpu = decoded(decoder.as_ref());
            let parity = Parity::compare(decoder.as_ref(), agreement, FrameIndex::FIRST, &cpu, &dump);
            assert!(parity.holds(), "{id} {pairs:?}, cell: {use_cell}: {parity}");
        }
    }
}

#[test]
fn a_picture_does_not_change_when_its_buffers_are_split() {
    let Some(device) = test_device("splitting::picture") else { return };
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &noise(ODD, SampleType::U16));
    let source = inline("raw", decoder.as_ref());
    let ((whole, one), (split, several)) = (draw(device, &source), draw(&small(device, 1000), &source));
    assert!(!one.contains("raw_samples_part1") && several.contains("raw_samples_part2"));
    assert!(whole.pixels().iter().any(|p| p[3] > 0.1));
    assert!(whole == split);
}

#[test]
fn too_many_parts_are_refused_with_both_numbers() {
    let Some(device) = test_device("splitting::too_many_parts") else { return };
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &noise(ODD, SampleType::U16));
    let error = small(device, 100).dump("raw", decoder.as_ref(), FrameIndex::FIRST, false).unwrap_err();
    // 26 parts and the dump itself.
    assert!(error.contains("27 storage buffers") && error.contains("binds 8"), "{error}");
}

#[test]
fn limits_cannot_be_raised_or_vanish() {
    let Some(device) = test_device("splitting::limits") else { return };
    let own = device.binding_limits();
    let all = BindingLimits { storage_words: u64::MAX, storage_buffers: u32::MAX };
    assert_eq!(device.with_binding_limits(all).binding_limits(), own);
    let none = BindingLimits { storage_words: 0, storage_buffers: 0 };
    assert_eq!(device.with_binding_limits(none).binding_limits().storage_words, 1);
    assert_eq!(device.binding_limits(), own, "the device itself keeps its limits");
}
