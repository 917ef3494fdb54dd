//! A device that ends loops early (llvmpipe does, after 65536 rounds of all loops of a thread) draws no wrong picture.

use cvr_core::codec::Site;
use cvr_core::render::{Filter, Projection, View};
use cvr_core::volume::SampleType;
use cvr_engine::testing::test_device;
use cvr_engine::{Device, Drawing, EngineError};

use super::scenes::{camera, mirror, rule, source, textured, view};
use super::subjects::{codec, encoded, settings};

/// The picture of a codec of many loops, decoded at every fetch, held to the mirror; or the error.
fn drawn(device: &Device, step_voxels: f32) -> Result<Result<(), String>, EngineError> {
    let volume = textured([24; 3], [1.0; 3], SampleType::U8);
    let decoder = encoded(codec("zfp").as_ref(), &settings(&[("rate", "16")]), &volume);
    let camera = camera(20.0, 10.0, Projection::Orthographic);
    let view = View { camera, step_voxels, ..view(SampleType::U8, [24, 24], Filter::Nearest) };
    let source = source(device, Site::Inline, "zfp", decoder.as_ref());
    let plan = cvr::registry::renderer("raycasting").unwrap().plan(&view, decoder.layout()).unwrap();
    let drawing = Drawing::new(device, &plan, &source, view.filter)?;
    drawing.draw_timed()?;
    let picture = drawing.read_image()?;
    let found = rule(drawing.filtering()).check(&mirror(&view, decoder.as_ref()), &picture);
    Ok(found.map(|_| ()).map_err(|e| e.to_string()))
}

#[test]
fn loops_that_a_device_ends_are_an_error_and_never_a_picture() {
    let Some(device) = test_device("cut_off::loops") else { return };
    assert_eq!(drawn(device, 1.0).unwrap(), Ok(()), "few samples are drawn");
    let many = drawn(device, 0.004);
    if device.info().to_string().contains("llvmpipe") {
        let problem = many.unwrap_err();
        assert!(matches!(problem, EngineError::CutOff { pixels } if pixels > 20), "{problem}");
        assert!(problem.to_string().contains("site deferred or host"), "{problem}");
    } else {
        assert_eq!(many.unwrap(), Ok(()));
    }
}
