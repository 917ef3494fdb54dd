use std::sync::Arc;

use cvr_core::shader::{BindingKind, BindingLimits};

use super::*;
use crate::VolumeTexture;
use crate::testing::test_device;
use crate::toy::Toy;

const FIRST: FrameIndex = FrameIndex::FIRST;

#[test]
fn a_dispatch_covers_every_voxel_within_the_limits() {
    for voxels in [1, 64, 65, 65535 * 64, 65535 * 64 + 1, 256 * 256 * 256, 1 << 28] {
        let [x, y, z] = dump_workgroups(voxels);
        assert!(u64::from(x) * u64::from(y) * u64::from(z) * WORKGROUP >= voxels);
        assert!(x <= 65535 && y <= 65535);
    }
    assert_eq!(dump_workgroups(1), [1, 1, 1]);
}

#[test]
fn every_voxel_of_odd_volumes_comes_back() {
    let Some(device) = test_device("dump::odd_volumes") else { return };
    // The last one needs a second row of workgroups.
    for (extent, channels) in
        [([1, 1, 1], 1), ([13, 17, 23], 1), ([13, 17, 23], 3), ([1, 301, 1], 1), ([300, 300, 47], 1)]
    {
        let toy = Toy::new(extent, channels);
        for use_cell in [false, true] {
            let got = device.dump("toy", &toy, FIRST, use_cell).unwrap();
            assert!(got == toy.values(), "{extent:?} × {channels}, cell: {use_cell}");
        }
    }
}

/// Pieces of any length, also of one voxel, give the whole.
#[test]
fn a_dump_in_pieces_is_the_whole() {
    let Some(device) = test_device("dump::pieces") else { return };
    for (extent, channels, most_bytes) in
        [([13, 17, 23], 1, 1000), ([13, 17, 23], 3, 1000), ([5, 4, 3], 3, 1), ([300, 300, 9], 1, 1 << 18)]
    {
        let toy = Toy::new(extent, channels);
        let source = DrawSource::Inline { codec: "toy", decoder: &toy, frame: FIRST, level: Level::FULL };
        let voxels = source.voxels().unwrap();
        for template in [cvr_shaders::DUMP, cvr_shaders::DUMP_CELL] {
            let shader = voxels.shader(device, &Program::dump(template), None).unwrap();
            let supplies = Supplies { buffers: &voxels.buffers, ..Supplies::default() };
            let shape = (toy.layout.extent, channels);
            let got = device.run_dump_in_pieces(&shader, supplies, shape, most_bytes).unwrap();
            assert!(got == toy.values(), "{extent:?} × {channels} in pieces of {most_bytes} bytes");
        }
    }
}

#[test]
fn a_texture_dumps_like_its_decoder() {
    let Some(device) = test_device("dump::texture") else { return };
    let toy = Toy::new([13, 17, 23], 3);
    let texture = VolumeTexture::upload(device, &toy.layout, &toy.values(), toy.decoded_form()).unwrap();
    let source = DrawSource::Texture(Arc::new(texture));
    let got = device.dump_source(&source, cvr_shaders::DUMP).unwrap();
    assert_eq!(got.iter().map(|v| v.round()).collect::<Vec<_>>(), toy.values());
}

#[test]
fn a_buffer_over_several_bindings_reads_as_one() {
    let Some(device) = test_device("dump::split_buffer") else { return };
    let toy = Toy::new([13, 17, 23], 1);
    let source = DrawSource::Inline { codec: "toy", decoder: &toy, frame: FIRST, level: Level::FULL };
    let voxels = source.voxels().unwrap();
    let limits = BindingLimits { storage_words: 1000, storage_buffers: 8 };
    let small = device.with_binding_limits(limits);
    let shader = voxels.shader(&small, &Program::dump(cvr_shaders::DUMP), None).unwrap();
    let parts = shader.bindings.iter().filter(|b| matches!(b.kind, BindingKind::Words { .. })).count();
    assert_eq!(parts, toy.words.len().div_ceil(1000));
    let supplies = Supplies { buffers: &voxels.buffers, ..Supplies::default() };
    assert_eq!(device.run_dump(&shader, supplies, toy.layout.extent, 1).unwrap(), toy.values());
}

#[test]
fn an_empty_buffer_reads_as_one_zero_word() {
    let Some(device) = test_device("dump::empty_buffer") else { return };
    let toy = Toy { words: Vec::new(), ..Toy::new([1, 1, 1], 1) };
    assert_eq!(device.dump("toy", &toy, FIRST, false), Ok(vec![0.0]));
}

#[test]
fn failures_are_sentences() {
    let Some(device) = test_device("dump::failures") else { return };
    let dump = |toy: &Toy| device.dump("toy", toy, FIRST, false).unwrap_err();
    let wrong =
        Toy { snippet: "fn toy_fetch(p: vec3<i32>) -> vec4<f32> { return 1; }", ..Toy::new([2; 3], 1) };
    let text = dump(&wrong);
    assert!(text.contains("toy/decode.wgsl"), "{text}");
    let text = dump(&Toy { snippet: "", ..Toy::new([2; 3], 1) });
    assert_eq!(text, "codec `toy` does not decode this stream in a shader");
    // The dump is refused before anything of its size is created.
    let huge = Toy { words: vec![0], ..Toy::new([1; 3], 1) };
    let mut huge_layout = huge.layout.clone();
    huge_layout.extent = Extent::new(2048, 2048, 1025).unwrap();
    let text = dump(&Toy { layout: huge_layout, ..huge });
    assert!(text.contains("offers 4294967295") && text.contains("a dump of"), "{text}");
}
