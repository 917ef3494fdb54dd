//! Skipping empty macrocells on the device: the pictures with and without it are equal bit for bit.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use cvr::registry::{Names, renderer};
use cvr_core::codec::{Decoder, Site};
use cvr_core::pipeline::undrawable;
use cvr_core::render::{
    ClipBox, ControlPoint, Filter, Image, LayerStep, MacrocellRanges, Macrocells, Projection, Shading,
    TransferFunction, View,
};
use cvr_core::shader::TextureSampling;
use cvr_core::volume::{FiniteVolume, FrameIndex, Level, SampleType};
use cvr_engine::Device;
use cvr_engine::testing::test_device;

use super::scenes::{camera, draw_by, source};
use super::subjects::{codec, encoded, hash, settings, volume};

const RENDERERS: [&str; 4] =
    ["raycasting", "slicing", "slicing,geometry=axis", "slicing,geometry=shells,opacity_correction=lerp"];

const SIZE: [u32; 3] = [27, 33, 18];

/// Single voxels on faces, edges and corners of macrocells, and a block. Empty otherwise. Signed, so that texels of the
/// sites *deferred* and *host* have an offset.
pub fn sparse(sample: SampleType) -> FiniteVolume {
    let hot = [[8, 12, 3], [7, 24, 12], [16, 15, 8], [0, 0, 0], [26, 32, 17]];
    volume(SIZE, [1.0, 0.8, 1.9], sample, |p| {
        let block = p[0] >= 17 && p[1] < 7 && p[2] < 8;
        if hot.contains(&p) || block || hash(p).is_multiple_of(997) { 120.0 } else { 0.0 }
    })
}

/// Shows a band of values: the voxels themselves, and values that interpolation passes next to them.
fn band(from: f32) -> Arc<TransferFunction> {
    let point = |value, alpha| ControlPoint { value, rgba: [1.0, 0.6, 0.3, alpha] };
    let points = vec![point(from, 0.0), point(from + 1.0, 0.8), point(127.0, 0.6)];
    Arc::new(TransferFunction::new(points).unwrap())
}

/// Views that differ from each other in many ways.
pub fn views(filter: Filter) -> [View; 4] {
    let view = |camera, step_voxels, from| View {
        size: [65, 49],
        camera,
        step_voxels,
        filter,
        ..View::new(band(from))
    };
    [
        view(camera(30.0, 20.0, Projection::Perspective), 0.3, 20.0),
        View {
            clip: Some(ClipBox { low: [0.1, 0.0, 0.2], high: [1.0, 0.9, 0.95] }),
            ..view(camera(0.0, 0.0, Projection::Orthographic), 1.0, 100.0)
        },
        View {
            shading: Some(Shading::default()),
            termination: 0.95,
            ..view(camera(-130.0, -35.0, Projection::Orthographic), 4.7, 5.0)
        },
        view(camera(90.0, 0.0, Projection::Perspective), 11.0, 1.0),
    ]
}

pub fn macrocells(decoder: &dyn Decoder, view: &View) -> Arc<Macrocells> {
    let stop = AtomicBool::new(false);
    let ranges = MacrocellRanges::decode(decoder, FrameIndex::FIRST, Level::FULL, &stop).unwrap().unwrap();
    Arc::new(ranges.classify(&view.transfer_function))
}

/// Pixels that differ in any bit.
pub fn mismatches(a: &Image, b: &Image) -> usize {
    let bits = |p: &[f32; 4]| p.map(f32::to_bits);
    a.pixels().iter().zip(b.pixels()).filter(|(a, b)| bits(a) != bits(b)).count()
}

pub fn visible(image: &Image) -> usize {
    image.pixels().iter().filter(|p| p[3] > 0.0).count()
}

/// All renderers at these sites, with these filters. Returns how often the texture unit interpolated.
fn check(
    device: &Device,
    id: &str,
    pairs: &[(&str, &str)],
    sample: SampleType,
    sites: &[Site],
    filters: &[Filter],
) -> usize {
    let decoder = encoded(codec(id).as_ref(), &settings(pairs), &sparse(sample));
    let mut hardware = 0;
    for &site in sites {
        let source = source(device, site, id, decoder.as_ref());
        for label in RENDERERS {
            if undrawable(label, site, Names::new().unwrap().known().renderers).is_some() {
                continue;
            }
            let renderer = renderer(label).unwrap();
            for &filter in filters {
                for view in views(filter) {
                    let macrocells = macrocells(decoder.as_ref(), &view);
                    assert!(macrocells.empty_share() > 0.1, "nothing to skip");
                    let (without, drawing) = draw_by(device, renderer.as_ref(), &view, &source);
                    let skipping = View { macrocells: Some(macrocells), ..view };
                    let (with, _) = draw_by(device, renderer.as_ref(), &skipping, &source);
                    let name = format!("{id} {sample} {site} {label} {filter} {:?}", skipping.camera);
                    assert!(visible(&without) > 0, "{name}: an empty picture");
                    assert_eq!(mismatches(&with, &without), 0, "{name}");
                    hardware += usize::from(drawing.filtering() == TextureSampling::Hardware);
                }
            }
        }
    }
    hardware
}

#[test]
fn raw_in_buffers_and_textures() {
    let Some(device) = test_device("skipping::raw") else { return };
    let filters = [Filter::Nearest, Filter::Linear];
    check(device, "raw", &[], SampleType::I8, &[Site::Inline], &filters);
    let hardware = check(device, "raw", &[], SampleType::I8, &[Site::Deferred], &[Filter::Linear]);
    assert!(hardware > 0, "no texture unit took part");
    check(device, "raw", &[], SampleType::I16, &[Site::Host], &[Filter::Linear]);
}

#[test]
fn s3dc_with_its_optimised_filter() {
    let Some(device) = test_device("skipping::s3dc") else { return };
    let filters = [Filter::Linear, Filter::OptimisedLinear];
    check(device, "s3dc", &[("block", "5x3x7")], SampleType::I16, &[Site::Inline], &filters);
    check(device, "s3dc", &[("block", "5x3x7")], SampleType::I16, &[Site::Deferred], &[Filter::Nearest]);
}

/// Empty layers are not even decoded.
#[test]
fn the_ring_skips_whole_layers() {
    let Some(device) = test_device("skipping::ring") else { return };
    let filters = [Filter::Nearest, Filter::Linear];
    let hardware = check(device, "raw", &[], SampleType::I8, &[Site::Ring], &filters);
    assert!(hardware > 0, "no texture unit took part");
    check(device, "s3dc", &[("block", "5x3x7")], SampleType::I16, &[Site::Ring], &filters);

    let block = volume([40; 3], [1.0; 3], SampleType::U8, |p| {
        if p.iter().all(|v| (17..23).contains(v)) { 120.0 } else { 0.0 }
    });
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &block);
    let view = View { size: [65, 49], ..View::new(band(20.0)) };
    let skipping = View { macrocells: Some(macrocells(decoder.as_ref(), &view)), ..view.clone() };
    let decodes = |view: &View| {
        let plan = renderer("slicing,geometry=axis").unwrap().plan_layers(view, decoder.layout()).unwrap();
        let [pass] = &plan.passes[..] else { panic!("one pass") };
        pass.inputs.steps.iter().filter(|step| matches!(step, LayerStep::Decode(_))).count()
    };
    // The block lies in the macrocells from 16 to 23. A layer pair across each of their faces reads one layer more.
    assert_eq!((decodes(&view), decodes(&skipping)), (40, 10));
}

/// The skipping shader is a different shader. If it skips nothing, its picture must be the same: in noise, every
/// rounding that chooses another voxel is visible. (`floor(x + offset)` in the nearest filter was such a rounding.)
#[test]
fn both_shaders_round_alike() {
    let Some(device) = test_device("skipping::rounding") else { return };
    let noise = volume([96; 3], [1.0; 3], SampleType::U8, |p| f64::from(hash(p) >> 24));
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &noise);
    let point = |value, alpha| ControlPoint { value, rgba: [1.0, 0.6, 0.3, alpha] };
    let haze = Arc::new(TransferFunction::new(vec![point(0.0, 0.0), point(255.0, 0.06)]).unwrap());
    let source = source(device, Site::Host, "raw", decoder.as_ref());
    for label in RENDERERS {
        let renderer = renderer(label).unwrap();
        for filter in [Filter::Nearest, Filter::Linear] {
            let camera = camera(180.0, -65.0, Projection::Perspective);
            let view = View { size: [160, 160], camera, filter, ..View::new(haze.clone()) };
            let macrocells = macrocells(decoder.as_ref(), &view);
            assert_eq!(macrocells.empty_share(), 0.0);
            let skipping = View { macrocells: Some(macrocells), ..view.clone() };
            let [with, without] =
                [&skipping, &view].map(|v| draw_by(device, renderer.as_ref(), v, &source).0);
            assert!(visible(&without) > 5000);
            assert_eq!(mismatches(&with, &without), 0, "{label} {filter}");
        }
    }
}

/// The twin: macrocells of a volume without the one visible voxel. Its picture then loses pixels.
#[test]
fn a_macrocell_that_shows_and_is_skipped_is_noticed() {
    let Some(device) = test_device("skipping::twin") else { return };
    let one =
        |value| volume([24; 3], [1.0; 3], SampleType::U8, move |p| if p == [12; 3] { value } else { 0.0 });
    let [seen, empty] = [120.0, 0.0].map(|value| encoded(codec("raw").as_ref(), &settings(&[]), &one(value)));
    let view = View { size: [65, 49], ..View::new(band(20.0)) };
    let honest = View { macrocells: Some(macrocells(seen.as_ref(), &view)), ..view.clone() };
    let cleared = View { macrocells: Some(macrocells(empty.as_ref(), &view)), ..view.clone() };
    let source = source(device, Site::Inline, "raw", seen.as_ref());
    for label in RENDERERS {
        let renderer = renderer(label).unwrap();
        let picture = |view| draw_by(device, renderer.as_ref(), view, &source).0;
        let without = picture(&view);
        assert_eq!(mismatches(&picture(&honest), &without), 0, "{label}");
        assert_eq!(mismatches(&picture(&cleared), &without), visible(&without), "{label}");
        assert!(visible(&without) > 0, "{label}");
    }
}
