//! A device that ends loops early (llvmpipe does, after 65536 rounds of all loops of a thread) draws rays in pieces. If
//! even that is not enough, it draws no picture instead of a wrong one.

use cvr::experiment::records::record::Status;
use cvr::registry::Names;
use cvr::site::target::Target;
use cvr_codec_tests::mutated::Mutated;
use cvr_core::codec::{Decoder, Site};
use cvr_core::render::{Filter, Projection, View};
use cvr_core::volume::SampleType;
use cvr_engine::testing::test_device;
use cvr_engine::{Device, Drawing, EngineError, RayPieces};

use super::runs::run;
use super::scenes::{camera, mirror, mirror_by, rule, source, textured, view};
use super::subjects::{codec, encoded, settings};

fn zfp(edge: u32, rate: &str) -> Box<dyn Decoder> {
    let volume = textured([edge; 3], [1.0; 3], SampleType::U8);
    encoded(codec("zfp").as_ref(), &settings(&[("rate", rate)]), &volume)
}

fn seen(size: [u32; 2], filter: Filter, step_voxels: f32) -> View {
    let camera = camera(20.0, 10.0, Projection::Orthographic);
    View { camera, step_voxels, ..view(SampleType::U8, size, filter) }
}

/// Slices of a codec with many loops, decoded at every fetch, compared with the mirror.
fn sliced(device: &Device, decoder: &dyn Decoder, view: &View) -> Result<(), EngineError> {
    let source = source(device, Site::Inline, "zfp", decoder);
    let slicing = cvr::registry::renderer("slicing").unwrap();
    let drawing = Drawing::new(device, &slicing.plan(view, decoder.layout()).unwrap(), &source, view.filter)?;
    drawing.draw_timed()?;
    drawing.draw_timed()?;
    let picture = drawing.read_image()?;
    rule(drawing.filtering()).check(&mirror_by(slicing.as_ref(), view, decoder), &picture).unwrap();
    Ok(())
}

/// A codec with many loops, decoded at every fetch. Compares its picture with the mirror and returns its pieces.
fn drawn(device: &Device, decoder: &dyn Decoder, view: &View) -> Result<Option<RayPieces>, EngineError> {
    let source = source(device, Site::Inline, "zfp", decoder);
    let plan = cvr::registry::renderer("raycasting").unwrap().plan(view, decoder.layout()).unwrap();
    let drawing = Drawing::new(device, &plan, &source, view.filter)?;
    drawing.draw_timed()?;
    let settled = drawing.ray_pieces();
    let time = drawing.draw_timed()?;
    println!("{settled:?}: {time:?}");
    assert_eq!(drawing.ray_pieces(), settled, "what the first frame has found is kept");
    let picture = drawing.read_image()?;
    rule(drawing.filtering()).check(&mirror(view, decoder), &picture).unwrap();
    Ok(settled)
}

fn ends_loops(device: &Device) -> bool {
    device.info().to_string().contains("llvmpipe")
}

#[test]
fn rays_whose_loops_a_device_ends_are_walked_in_pieces() {
    let Some(device) = test_device("cut_off::pieces") else { return };
    let few = drawn(device, zfp(24, "16").as_ref(), &seen([24, 24], Filter::Nearest, 1.0)).unwrap();
    assert_eq!(few, None, "few samples are drawn at once");
    // Many samples of one voxel, and few of eight.
    for (edge, view) in
        [(24, seen([24, 24], Filter::Nearest, 0.004)), (48, seen([40, 40], Filter::Linear, 0.5))]
    {
        let pieces = drawn(device, zfp(edge, "16").as_ref(), &view).unwrap();
        if ends_loops(device) {
            let RayPieces { samples, pieces } = pieces.unwrap();
            assert!(samples.is_power_of_two() && samples > 1 && pieces > 1, "{samples} × {pieces}");
        } else {
            assert_eq!(pieces, None);
        }
    }
}

/// Loops before a fetch that no compiler can remove.
const LONG: &str = "\
fn zfp_fetch(p: vec3<i32>) -> vec4<f32> {
    var mixed = u32(p.x);
    for (var i = 0u; i < zfp_rounds; i++) {
        mixed = mixed * 1664525u + 1013904223u;
    }
    if mixed == 7u {
        return vec4<f32>(0.0);
    }
";

/// A decoder whose every fetch takes `rounds` rounds more.
fn longer(rounds: u32) -> Mutated {
    let text = LONG.replace("zfp_rounds", &format!("{rounds}u"));
    Mutated::snippet(zfp(24, "4"), "fn zfp_fetch(p: vec3<i32>) -> vec4<f32> {\n", &text)
}

#[test]
fn loops_that_are_too_long_for_a_single_sample_are_an_error_and_never_a_picture() {
    let Some(device) = test_device("cut_off::loops") else { return };
    let view = seen([24, 24], Filter::Nearest, 1.0);
    let pieces = drawn(device, &longer(40_000), &view).unwrap();
    let long = drawn(device, &longer(70_000), &view);
    if ends_loops(device) {
        assert_eq!(pieces.unwrap().samples, 1);
        let problem = long.unwrap_err();
        assert!(matches!(problem, EngineError::CutOff { pixels } if pixels > 20), "{problem}");
        assert!(problem.to_string().contains("site deferred or host"), "{problem}");
    } else {
        assert_eq!((pieces, long.unwrap()), (None, None));
    }
}

/// The loops end in the last sample of a ray, so no later sample is missing.
#[test]
fn a_ray_of_one_sample_that_is_cut_off_is_noticed() {
    let Some(device) = test_device("cut_off::last_sample") else { return };
    let long = drawn(device, &longer(70_000), &seen([24, 24], Filter::Nearest, 100.0));
    if ends_loops(device) {
        assert!(matches!(long, Err(EngineError::CutOff { .. })), "{long:?}");
    } else {
        assert_eq!(long.unwrap(), None);
    }
}

/// A fragment is one sample. Fragments that are cut off are an error, and the others are drawn, for any number of
/// fragments in a pixel.
#[test]
fn fragments_whose_loops_a_device_ends_are_an_error_and_never_a_picture() {
    let Some(device) = test_device("cut_off::fragments") else { return };
    for step in [1.0, 100.0] {
        let view = seen([24, 24], Filter::Nearest, step);
        sliced(device, &longer(40_000), &view).unwrap();
        let long = sliced(device, &longer(70_000), &view);
        if ends_loops(device) {
            let problem = long.unwrap_err();
            assert!(matches!(problem, EngineError::CutOff { pixels } if pixels > 20), "{problem}");
        } else {
            long.unwrap();
        }
    }
}

const CONFIG: &str = r##"
[experiment]
name = "pieces"
seed = 3

[[volume]]
name = "clouds"
generate = "turbulence"
dims = [32, 32, 32]
dtype = "u8"

[[codec]]
id = "zfp"
rate = 16

[pipeline]
renderer = ["raycasting"]
site = ["inline", "host"]
filter = ["linear"]

[[scene]]
name = "front"
size = [16, 16]
step_voxels = 0.25
transfer_function = [[0.0, "#00000000"], [120.0, "#ffb04010"], [255.0, "#ffffff40"]]
"##;

/// A cell that is drawn in pieces says so, and its frame time covers all of them.
#[test]
fn a_record_tells_in_how_many_pieces_rays_were_walked() {
    let Some(device) = test_device("cut_off::record") else { return };
    let folder = tempfile::tempdir().unwrap();
    let target = Target::Device(device.clone());
    let outcome = run(&Names::new().unwrap(), CONFIG, &target, folder.path());
    let [inline, host] = &outcome.records[..] else { panic!("two cells") };
    for record in [inline, host] {
        assert_eq!((record.status, &record.error), (Status::Ok, &None), "{}", record.site);
        let notes = record.notes.clone().unwrap_or_default();
        println!("{}: {:?} ms, {:?} ×; {notes}", record.site, record.frame_ms, record.relative_frame_time);
        assert_eq!(
            notes.contains("rays walked in "),
            ends_loops(device) && record.site == "inline",
            "{notes}"
        );
    }
}
