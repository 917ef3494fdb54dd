//! The site *ring*: slices drawn from four layers at a time, compared with slices from the whole decoded frame.

use std::collections::{BTreeMap, BTreeSet};

use cvr::experiment::records::record::Record;
use cvr::experiment::running::encoded::{Encoded, encode};
use cvr::registry;
use cvr::site::coded::CodedFrame;
use cvr::site::picture::VoxelSource;
use cvr::site::target::Target;
use cvr_codec_tests::mutated::Mutated;
use cvr_core::codec::{Decoder, Parity, Progress, Site, TexelFormat};
use cvr_core::render::{
    Blending, Camera, ClipBox, Filter, LayerStep, Light, Plan, Projection, RING_LAYERS, Renderer,
    TransferFunction, View,
};
use cvr_core::shader::{BindingLimits, TextureSampling};
use cvr_core::volume::{Axis, FrameIndex, Level, SampleType};
use cvr_engine::testing::test_device;
use cvr_engine::{Device, DrawSource, Drawing, EngineError};
use cvr_raycasting::Raycasting;
use cvr_slicing::{Geometry, OpacityCorrection, Slicing};

use super::colour::{coloured, views as colour_views};
use super::scenes::{
    camera, deferred, draw_by, lit, mirror_by, ring, rule, source, sums_single, textured, transfer_function,
    view,
};
use super::subjects::{ODD, accepted, codec, decoded, encoded, noise, settings, sweep};

use Projection::{Orthographic, Perspective};

const FIRST: FrameIndex = FrameIndex::FIRST;

const SLICING: Slicing = Slicing {
    geometry: Geometry::Axis,
    opacity_correction: OpacityCorrection::Exact,
    blending: Blending::Float32,
};

/// Cameras that look along each axis, both ways.
fn cameras() -> [Camera; 6] {
    [
        camera(20.0, 10.0, Perspective),
        camera(-160.0, -15.0, Orthographic),
        camera(75.0, 20.0, Orthographic),
        camera(-110.0, 10.0, Perspective),
        camera(10.0, 70.0, Perspective),
        camera(30.0, -75.0, Orthographic),
    ]
}

fn plan(view: &View, decoder: &dyn Decoder) -> Plan {
    SLICING.plan_layers(view, decoder.layout()).unwrap()
}

fn axis_of(plan: &Plan) -> Axis {
    let [pass] = &plan.passes[..] else { panic!("one pass") };
    pass.pipeline.layers().expect("layer by layer")
}

/// Whether the first layers that a plan decodes are the last of the volume.
fn from_above(plan: &Plan) -> bool {
    let [pass] = &plan.passes[..] else { panic!("one pass") };
    let mut decoded =
        pass.inputs.steps.iter().filter_map(|s| if let LayerStep::Decode(n) = s { Some(*n) } else { None });
    decoded.next() > decoded.next_back()
}

/// Compares the pictures of the ring, of the whole frame and, if requested, of the mirror. Returns the largest
/// difference from the whole frame, in 255ths.
fn compare(
    device: &Device,
    (id, decoder): (&str, &dyn Decoder),
    view: &View,
    mirrored: bool,
    name: &str,
) -> f32 {
    let (from_ring, drawing) = draw_by(device, &SLICING, view, &ring(id, decoder));
    let (from_frame, whole) = draw_by(device, &SLICING, view, &deferred(device, id, decoder));
    assert_eq!(drawing.filtering(), whole.filtering(), "{name}");
    assert_eq!(drawing.fallback(), whole.fallback(), "{name}");
    let agreement = rule(drawing.filtering()).check(&from_frame, &from_ring);
    let agreement = agreement.unwrap_or_else(|e| panic!("{name}, whole frame: {e}"));
    assert!(agreement.visible_pixels > 0, "{name}: an empty picture");
    if !mirrored {
        return agreement.max_difference * 255.0;
    }
    let mirror = mirror_by(&SLICING, view, decoder);
    let mut rule = rule(drawing.filtering());
    if view.filter == Filter::Nearest && view.shading.is_some() {
        // A sample on a voxel's face may fall to either side, and its gradient then lights it differently.
        rule.limit = 8.0 / 255.0;
    }
    rule.check(&mirror, &from_ring).unwrap_or_else(|e| panic!("{name}, mirror: {e}"));
    agreement.max_difference * 255.0
}

#[test]
fn pictures_are_those_of_the_whole_frame_along_every_axis_both_ways() {
    let Some(device) = test_device("ring::pictures") else { return };
    let mirrored = sums_single(device, "ring::pictures, against the mirror");
    let mut seen = BTreeSet::new();
    let mut largest = BTreeMap::new();
    for (id, pairs, sample) in [
        ("raw", &[][..], SampleType::U8),
        ("s3dc", &[("block", "4"), ("index_bits", "4")], SampleType::I16),
        ("vq", &[("codeword_bits", "16")], SampleType::U8),
    ] {
        let volume = textured(ODD, [1.0, 1.5, 0.7], sample);
        let decoder = encoded(codec(id).as_ref(), &settings(pairs), &volume);
        for camera in cameras() {
            // Texture units weigh 8-bit texels with 8 bits, and layers across x and y have other texture axes than the
            // whole frame. Few long steps do not average this out, so they need single precision.
            let single = decoder.decoded_form().format == TexelFormat::Float32;
            let steps = [(Filter::Nearest, 0.5), (Filter::Nearest, 1.7), (Filter::Linear, 0.5)];
            let longer = single.then_some([(Filter::Linear, 1.7), (Filter::Linear, 6.0)]);
            for (filter, step_voxels) in steps.into_iter().chain(longer.into_iter().flatten()) {
                let unlit = View { camera, step_voxels, ..view(sample, [65, 49], filter) };
                let planned = plan(&unlit, decoder.as_ref());
                seen.insert((axis_of(&planned), from_above(&planned)));
                for (view, what) in [(lit(unlit.clone(), Light::Camera), "lit"), (unlit, "unlit")] {
                    let name = format!("{id} {filter} {step_voxels} {what} {camera:?}");
                    let difference = compare(device, (id, decoder.as_ref()), &view, mirrored, &name);
                    let so_far = largest.entry((filter.name(), axis_of(&planned))).or_insert(0.0_f32);
                    *so_far = so_far.max(difference);
                }
            }
        }
    }
    assert_eq!(seen.len(), 6, "three axes, both ways: {seen:?}");
    println!("largest differences to the whole frame, in 255ths: {largest:?}");
}

#[test]
fn thin_volumes_colours_boxes_and_long_steps() {
    let Some(device) = test_device("ring::shapes") else { return };
    let clip = Some(ClipBox { low: [0.1, 0.3, 0.21], high: [0.8, 0.93, 0.6] });
    for size in [[1, 17, 23], [13, 1, 23], [13, 17, 1], [2, 3, 2], [1, 1, 1]] {
        let sample = SampleType::F32;
        let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &textured(size, [1.0; 3], sample));
        for camera in cameras() {
            for (step_voxels, clip) in [(0.4, None), (6.0, None), (0.7, clip)] {
                let view = View { camera, step_voxels, clip, ..view(sample, [49, 33], Filter::Linear) };
                // Any value shows, however few voxels there are.
                let mut points = transfer_function(sample).points().to_vec();
                points.iter_mut().for_each(|point| point.rgba[3] = point.rgba[3].max(0.2));
                let transfer_function = TransferFunction::new(points).unwrap().into();
                let view = lit(View { transfer_function, ..view }, Light::Camera);
                let name = format!("{size:?} {step_voxels} {clip:?} {camera:?}");
                compare(device, ("raw", decoder.as_ref()), &view, true, &name);
            }
        }
    }
}

#[test]
fn colours_whatever_decides_their_opacity() {
    let Some(device) = test_device("ring::colours") else { return };
    let mirrored = sums_single(device, "ring::colours, against the mirror");
    for (id, pairs, sample) in [
        ("raw", &[][..], SampleType::U8),
        ("s3dc", &[("block", "4"), ("index_bits", "8")], SampleType::U8),
        ("raw", &[], SampleType::F32),
    ] {
        let volume = coloured(sample);
        let decoder = encoded(codec(id).as_ref(), &settings(pairs), &volume);
        for (i, view) in colour_views(sample, &volume).into_iter().enumerate() {
            let view = View { camera: cameras()[i % 6], ..view };
            let name = format!("{id} {sample} {:?}, lit {}", view.colour_opacity, view.shading.is_some());
            compare(device, (id, decoder.as_ref()), &view, mirrored, &name);
        }
    }
}

/// The failing twin: a ring that is off by one layer, in its content or in its slot numbers.
#[test]
fn a_ring_off_by_one_layer_is_seen() {
    let Some(device) = test_device("ring::twins") else { return };
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &textured(ODD, [1.0; 3], SampleType::U8));
    let layers = |axis: Axis| decoder.layout().extent.to_array()[axis.index()];
    for camera in cameras() {
        for filter in [Filter::Nearest, Filter::Linear] {
            let view = View { camera, ..view(SampleType::U8, [65, 49], filter) };
            let (expected, whole) =
                draw_by(device, &SLICING, &view, &deferred(device, "raw", decoder.as_ref()));
            let right = plan(&view, decoder.as_ref());
            let drawn = |change: &dyn Fn(&mut LayerStep)| {
                let mut plan = right.clone();
                let [pass] = &mut plan.passes[..] else { panic!("one pass") };
                pass.inputs.steps.iter_mut().for_each(change);
                let drawing = Drawing::new(device, &plan, &ring("raw", decoder.as_ref()), filter).unwrap();
                drawing.draw_timed().unwrap();
                rule(whole.filtering()).check(&expected, &drawing.read_image().unwrap())
            };
            let last = layers(axis_of(&right)) - 1;
            drawn(&|_| {}).unwrap();
            let other_layer = drawn(&|step| {
                if let LayerStep::Decode(layer) = step {
                    *layer = (*layer + 1).min(last);
                }
            });
            let other_slot = drawn(&|step| {
                if let LayerStep::Place(slot) = step {
                    *slot = (*slot + 1) % RING_LAYERS;
                }
            });
            let other_cell = drawn(&|step| {
                if let LayerStep::Draw { between, .. } = step {
                    *between += 1;
                }
            });
            for (wrong, what) in [(other_layer, "layer"), (other_slot, "slot"), (other_cell, "cell")] {
                assert!(wrong.is_err(), "{filter}, {camera:?}: another {what} goes unnoticed");
            }
        }
    }
}

fn read(device: &Device, id: &str, decoder: &dyn Decoder, camera: Camera) -> Result<Vec<f32>, EngineError> {
    let view = View { camera, ..view(SampleType::U8, [8, 8], Filter::Nearest) };
    let drawing = Drawing::new(device, &plan(&view, decoder), &ring(id, decoder), view.filter)?;
    Ok(drawing.read_layers()?.unwrap())
}

/// One camera for each axis.
fn one_for_each_axis(decoder: &dyn Decoder) -> [Camera; 3] {
    Axis::ALL.map(|axis| {
        let along = |camera: &Camera| {
            axis_of(&plan(
                &View { camera: *camera, ..view(SampleType::U8, [8, 8], Filter::Nearest) },
                decoder,
            ))
        };
        cameras().into_iter().find(|camera| along(camera) == axis).unwrap()
    })
}

/// Every codec that decodes inline, through the ring, with alternating settings and sample types.
#[test]
fn every_voxel_that_comes_through_the_ring_is_what_the_cpu_decodes() {
    let Some(device) = test_device("ring::every_voxel") else { return };
    let mut samples = SampleType::ALL.into_iter().cycle();
    for codec in registry::codecs().unwrap().iter().filter(|codec| codec.info().offers(Site::Ring)) {
        let id = codec.info().id;
        for settings in sweep(codec.as_ref(), 0) {
            if !codec.offers(&codec.info().complete(&settings).unwrap(), Site::Ring) {
                continue;
            }
            let sample = samples.next().unwrap();
            let Some(decoder) = accepted(codec.as_ref(), &settings, &noise(ODD, sample)) else { continue };
            let (decoder, cpu) = (decoder.as_ref(), decoded(decoder.as_ref()));
            let agreement = decoder.shader().unwrap().agreement();
            for camera in one_for_each_axis(decoder) {
                let values = read(device, id, decoder, camera).unwrap();
                let parity = Parity::compare(decoder, agreement, FIRST, &cpu, &values);
                assert!(parity.holds(), "{id} {settings} {sample} {camera:?}: {parity}");
                assert_eq!(values.len(), cpu.len());
            }
        }
    }
}

#[test]
fn colours_come_through_the_ring_and_so_does_a_split_stream() {
    let Some(device) = test_device("ring::split") else { return };
    let volume = coloured(SampleType::U8);
    for (id, pairs) in [("raw", &[][..]), ("s3dc", &[("block", "4"), ("index_bits", "4")])] {
        let decoder = encoded(codec(id).as_ref(), &settings(pairs), &volume);
        let (decoder, cpu) = (decoder.as_ref(), decoded(decoder.as_ref()));
        let small = BindingLimits { storage_words: 3500, storage_buffers: 8 };
        for device in [device, &device.with_binding_limits(small)] {
            for camera in one_for_each_axis(decoder) {
                let values = read(device, id, decoder, camera).unwrap();
                let agreement = decoder.shader().unwrap().agreement();
                assert!(Parity::compare(decoder, agreement, FIRST, &cpu, &values).holds(), "{id} {camera:?}");
            }
        }
        // A layer is not decoded in pieces.
        let tiny = device.with_binding_limits(BindingLimits { storage_words: 700, storage_buffers: 64 });
        let error = read(&tiny, id, decoder, one_for_each_axis(decoder)[0]).unwrap_err();
        assert!(matches!(error, EngineError::TooLarge { .. }), "{error}");
    }
}

/// The failing twin of the comparison: a wrong snippet reaches the ring, and the picture's own comparison detects it.
#[test]
fn a_wrong_snippet_is_caught() {
    let Some(device) = test_device("ring::wrong_snippet") else { return };
    for (id, pairs, from, to) in [
        ("raw", &[][..], "lane * raw_bits", "(lane + 1u) * raw_bits"),
        (
            "s3dc",
            &[("block", "4"), ("index_bits", "4")],
            "(1u << s3dc_index_bits) - 1u",
            "(1u << s3dc_index_bits) - 2u",
        ),
    ] {
        let volume = noise(ODD, SampleType::U8);
        let mutated = Mutated::snippet(encoded(codec(id).as_ref(), &settings(pairs), &volume), from, to);
        for camera in one_for_each_axis(&mutated) {
            let values = read(device, id, &mutated, camera).unwrap();
            let agreement = mutated.shader().unwrap().agreement();
            let parity = Parity::compare(&mutated, agreement, FIRST, &decoded(&mutated), &values);
            assert!(!parity.holds(), "{id}: `{to}` goes unnoticed along {camera:?}");
        }
    }
}

/// The same in a run: the cell fails, and its record gives the number of samples that differ.
#[test]
fn a_cell_whose_ring_holds_other_values_fails() {
    let Some(device) = test_device("ring::failing_cell") else { return };
    let (folder, volume) = (tempfile::tempdir().unwrap(), textured(ODD, [1.0; 3], SampleType::U8));
    let raw = codec("raw");
    let settings = raw.info().default_settings();
    let mut right =
        encode(raw.as_ref(), &settings, &volume, (folder.path(), 64), &Progress::silent()).unwrap();
    let target = Target::Device(device.clone());
    let view = view(SampleType::U8, [16, 16], Filter::Linear);
    let entered = |encoded: &Encoded| {
        let decoded = || encoded.frame(FIRST);
        let coded = encoded.coded("raw", FIRST);
        let voxels = VoxelSource::prepare(&target, Site::Ring, coded, &decoded).unwrap();
        let picture = target.picture(&SLICING, &view, &voxels).unwrap();
        let mut record = Record::default();
        let expected = encoded.expected("raw", FIRST).unwrap();
        let checked = picture.check(&expected).unwrap().unwrap();
        (record.enter_checked(&checked), record.parity_mismatches)
    };
    assert_eq!(entered(&right), (Ok(()), Some(0)));
    let same = encoded(raw.as_ref(), &settings, &volume);
    let mutated = Mutated::snippet(same, "lane * raw_bits", "(lane + 1u) * raw_bits");
    right.decoder = std::sync::Arc::new(mutated);
    let (result, mismatches) = entered(&right);
    let told = result.unwrap_err();
    assert!(
        told.contains("through the ring is not what the CPU decodes")
            && told.contains("; the first is voxel 0 0 0 (frame 0): "),
        "{told}"
    );
    assert!(mismatches.unwrap() > 1000, "{mismatches:?}");
}

#[test]
fn what_is_resident_is_four_layers_a_buffer_of_one_and_the_stream() {
    let Some(device) = test_device("ring::resident") else { return };
    let s3dc = [("block", "4"), ("index_bits", "4")];
    for (id, pairs, texel_bytes) in [("raw", &[][..], 1), ("s3dc", &s3dc, 4)] {
        let decoder = encoded(codec(id).as_ref(), &settings(pairs), &noise([130, 67, 90], SampleType::U8));
        let decoder = decoder.as_ref();
        let words: usize =
            decoder.shader().unwrap().resources(FIRST).unwrap().iter().map(|r| r.words.len()).sum();
        for (camera, [width, height]) in
            one_for_each_axis(decoder).into_iter().zip([[67_u64, 90], [130, 90], [130, 67]])
        {
            let view = View { camera, ..view(SampleType::U8, [8, 8], Filter::Linear) };
            let (_, drawing) = draw_by(device, &SLICING, &view, &ring(id, decoder));
            let row = (width * texel_bytes).next_multiple_of(256);
            let expected = 4 * width * height * texel_bytes + row * height + 4 * words as u64;
            assert_eq!(drawing.resident_bytes(), expected, "{id} {width}×{height}");
            let (_, whole) = draw_by(device, &SLICING, &view, &deferred(device, id, decoder));
            assert!(drawing.resident_bytes() < whole.resident_bytes(), "{id} {width}×{height}");
        }
    }
}

#[test]
fn a_volume_longer_than_a_texture_goes_through_the_ring() {
    let Some(device) = test_device("ring::long") else { return };
    let limit = device.capabilities().texture_edge_voxels;
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &noise([3, 2, limit + 9], SampleType::U8));
    let camera = one_for_each_axis(decoder.as_ref())[2];
    assert!(read(device, "raw", decoder.as_ref(), camera).unwrap() == decoded(decoder.as_ref()));
    let across = one_for_each_axis(decoder.as_ref())[0];
    let error = read(device, "raw", decoder.as_ref(), across).unwrap_err();
    assert!(error.to_string().contains(&format!("offers {limit}")), "{error}");
}

#[test]
fn what_does_not_go_together_is_refused() {
    let Some(device) = test_device("ring::refusals") else { return };
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &textured(ODD, [1.0; 3], SampleType::U8));
    let view = view(SampleType::U8, [16, 16], Filter::Linear);
    let planes = Slicing::default();
    for renderer in [&Raycasting as &dyn Renderer, &planes] {
        let error = renderer.plan_layers(&view, decoder.layout()).unwrap_err();
        assert!(error.to_string().contains("layer by layer"), "{error}");
        // Nor does the way that the application takes.
        let target = Target::Device(device.clone());
        let coded = CodedFrame { codec: "raw", decoder: decoder.as_ref(), key: (FIRST, Level::FULL) };
        let decoded = || Err("a ring draws nothing that the CPU decodes".to_owned());
        let voxels = VoxelSource::prepare(&target, Site::Ring, coded, &decoded).unwrap();
        assert!(target.picture(renderer, &view, &voxels).is_err());
    }
    let layers = plan(&view, decoder.as_ref());
    let whole = SLICING.plan(&view, decoder.layout()).unwrap();
    let refused = |plan: &Plan, source: &DrawSource<'_>| {
        let error = Drawing::new(device, plan, source, Filter::Linear).unwrap_err();
        assert!(matches!(error, EngineError::Unsupported(_)), "{error}");
    };
    refused(&layers, &source(device, Site::Inline, "raw", decoder.as_ref()));
    refused(&layers, &source(device, Site::Deferred, "raw", decoder.as_ref()));
    refused(&whole, &ring("raw", decoder.as_ref()));
    let twice = Plan { passes: [layers.passes.clone(), layers.passes.clone()].concat(), ..layers.clone() };
    refused(&twice, &ring("raw", decoder.as_ref()));
    let (_, drawing) = draw_by(device, &SLICING, &view, &ring("raw", decoder.as_ref()));
    assert_eq!(drawing.filtering(), TextureSampling::Hardware);
    assert!(drawing.wgsl().contains("fn raw_fetch(") && drawing.wgsl().contains("ring_layers"));
}
