//! Further views of a volume: other inputs without new pipelines.

use cvr::experiment::records::record::Status;
use cvr::registry::{Names, renderer};
use cvr::site::target::Target;
use cvr_core::codec::Site;
use cvr_core::render::{Camera, ClipBox, Filter, Light, Projection, View};
use cvr_core::volume::SampleType;
use cvr_engine::Drawing;
use cvr_engine::testing::test_device;

use super::runs::run;
use super::scenes::{camera, draw_by, lit, mirror_by, rule, source, sums_single, textured, view};
use super::skipping::mismatches;
use super::subjects::{codec, encoded, settings};

/// A turn of 120 views around the volume, each with its own clip box and light.
fn turn() -> Vec<View> {
    let of = |i: u16| {
        let still = lit(view(SampleType::U8, [32, 24], Filter::Linear), Light::Camera);
        let far = f64::from(i) / 120.0;
        let near = far as f32;
        let clip = ClipBox { low: [0.0, 0.3 * near, 0.0], high: [1.0 - 0.2 * near, 1.0, 1.0] };
        View { camera: camera(360.0 * far, 20.0 * far, Projection::Perspective), clip: Some(clip), ..still }
    };
    (0..120).map(of).collect()
}

#[test]
fn a_turn_of_120_views_compiles_one_pipeline_per_renderer() {
    let Some(device) = test_device("further_views::turn") else { return };
    let volume = textured([19, 23, 17], [1.0, 1.4, 0.8], SampleType::U8);
    let decoder = encoded(codec("s3dc").as_ref(), &settings(&[]), &volume);
    let views = turn();
    for label in ["raycasting", "slicing", "slicing,geometry=axis", "slicing,geometry=shells"] {
        let renderer = renderer(label).unwrap();
        // It counts its own pipelines.
        let device = device.without_block_textures();
        let source = source(&device, Site::Inline, "s3dc", decoder.as_ref());
        let before = device.pipelines_compiled();
        let plan = |view: &View| renderer.plan(view, decoder.layout()).unwrap();
        let mut drawing = Drawing::new(&device, &plan(&views[0]), &source, views[0].filter).unwrap();
        let first = device.pipelines_compiled() - before;
        // A picture blended from a codec's snippet is checked once, by a pipeline that marks ended loops.
        assert_eq!(first, if label == "raycasting" { 1 } else { 2 }, "{label}");
        for (i, view) in views.iter().enumerate() {
            drawing.set_inputs(&plan(view)).unwrap();
            drawing.draw().unwrap();
            if i % 40 == 17 {
                let image = drawing.read_image().unwrap();
                let (alone, _) = draw_by(&device, renderer.as_ref(), view, &source);
                assert_eq!(mismatches(&alone, &image), 0, "{label}, view {i}: a drawing of its own differs");
                let rule = rule(drawing.filtering());
                if sums_single(&device, "further_views::turn") {
                    rule.check(&mirror_by(renderer.as_ref(), view, decoder.as_ref()), &image).unwrap();
                }
            }
        }
        assert_eq!(device.pipelines_compiled() - before, first, "{label}: further views compile nothing");
    }
}

/// Mesa 22.3 ended the process where fragments read four uniform buffers: view, clip box, light and slabs.
#[test]
fn slices_that_are_lit_clipped_and_interpolated_are_drawn() {
    let Some(device) = test_device("further_views::four_uniforms") else { return };
    let volume = textured([19, 23, 17], [1.0; 3], SampleType::U8);
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &volume);
    let renderer = renderer("slicing,opacity_correction=lerp").unwrap();
    let clip = Some(ClipBox { low: [0.1, 0.2, 0.0], high: [0.9, 1.0, 0.8] });
    let camera = Camera { zoom: 1.2, ..camera(30.0, 20.0, Projection::Perspective) };
    let still = lit(view(SampleType::U8, [40, 30], Filter::Linear), Light::Fixed);
    let view = View { camera, clip, ..still };
    for site in [Site::Inline, Site::Host] {
        let source = source(device, site, "raw", decoder.as_ref());
        let (image, drawing) = draw_by(device, renderer.as_ref(), &view, &source);
        assert!(drawing.wgsl().contains("opacity_lerp.wgsl") && drawing.wgsl().contains("bounds/clip.wgsl"));
        assert_eq!(drawing.wgsl().matches("var<uniform>").count(), 1);
        assert!(image.pixels().iter().any(|pixel| pixel[3] > 0.1));
        if sums_single(device, "further_views::four_uniforms") {
            rule(drawing.filtering())
                .check(&mirror_by(renderer.as_ref(), &view, decoder.as_ref()), &image)
                .unwrap();
        }
    }
}

const RUN: &str = r##"
[experiment]
name = "turn"
seed = 3

[[volume]]
name = "blobs"
generate = "advected-blobs"
dims = [16, 16, 16]
dtype = "u8"
frames = 3

[[codec]]
id = "raw"

[[codec]]
id = "s3dc"

[pipeline]
renderer = ["raycasting", "slicing"]
site = ["inline", "deferred"]
filter = ["linear"]

[[scene]]
name = "front"
size = [16, 16]
transfer_function = [[0.0, "#00000000"], [120.0, "#ffb04010"], [255.0, "#ffffff40"]]
"##;

/// Further frames and scenes of a run compile nothing.
#[test]
fn a_run_compiles_its_pipelines_once_for_all_frames_and_scenes() {
    let Some(device) = test_device("further_views::run") else { return };
    let scene = RUN.split_once("[[scene]]").unwrap().1;
    let side =
        format!("\n[[scene]]{scene}camera = {{ azimuth = 80.0 }}\nframe = [0, 2]\n").replace("front", "side");
    let compiled = |config: &str| {
        let folder = tempfile::tempdir().unwrap();
        let device = device.without_block_textures();
        let outcome = run(&Names::new().unwrap(), config, &Target::Device(device.clone()), folder.path());
        assert!(outcome.records.iter().all(|record| record.status == Status::Ok), "{:?}", outcome.records);
        (outcome.records.len(), device.pipelines_compiled())
    };
    let (cells, pipelines) = compiled(RUN);
    assert_eq!(compiled(&format!("{RUN}{side}")), (2 * cells, pipelines));
}
