//! An unknown renderer: its own WGSL, uniform and buffer, without changes of core or engine.

use cvr_core::codec::Site;
use cvr_core::render::{
    Contents, Filter, Image, Pass, Plan, RayWalk, RenderError, SceneModules, Stage, Template, View,
};
use cvr_core::shader::Variable;
use cvr_core::volume::{SampleType, VolumeLayout};
use cvr_engine::testing::test_device;
use cvr_engine::{Drawing, EngineError};

use super::scenes::{mirror, source, textured, view};
use super::subjects::{codec, encoded, settings};

/// Shows the brightest sample of a ray, faded towards a colour by its index, in steps of a palette.
const BRIGHTEST: Template = Template {
    file: "brightest/brightest.wgsl",
    source: "\
struct Palette {
    tint: vec3<f32>,
    entries: u32,
}

fn gather(so_far: vec4<f32>, x: vec3<f32>, direction: vec3<f32>, piece: f32) -> Gathered {
    let value = classify(volume_sample(x)).a;
    if value <= so_far.a {
        return Gathered(so_far, false);
    }
    let entry = min(u32(value * f32(inputs.palette.entries)), inputs.palette.entries - 1u);
    return Gathered(vec4<f32>(inputs.palette.tint * brightness[entry], value), false);
}
",
};

const TINT: [f32; 3] = [1.0, 0.5, 0.25];

fn plan(view: &View, layout: &VolumeLayout, brightness: &[f32]) -> Result<Plan, RenderError> {
    let mut scene = SceneModules::new(view, layout)?;
    let palette = Variable::Uniform { name: "palette", wgsl_type: "Palette" };
    let words = [TINT.map(f32::to_bits).to_vec(), vec![brightness.len() as u32]].concat();
    scene.read(palette, bytemuck::cast_slice(&words).to_vec());
    scene.read(Variable::read("brightness", "array<f32>"), bytemuck::cast_slice(brightness).to_vec());
    let pass = scene.pass(Stage::Rays(RayWalk::default()), &[BRIGHTEST]);
    Ok(Plan { size: view.size, passes: vec![pass] })
}

#[test]
fn a_renderer_brings_its_own_wgsl_uniform_and_buffer() {
    let Some(device) = test_device("own_renderer") else { return };
    let volume = textured([19, 23, 17], [1.0; 3], SampleType::U8);
    let decoder = encoded(codec("s3dc").as_ref(), &settings(&[]), &volume);
    let view = view(SampleType::U8, [40, 30], Filter::Linear);
    let seen = mirror(&view, decoder.as_ref());
    let steps = [0.25, 0.5, 0.75, 1.0];
    for site in [Site::Inline, Site::Host] {
        let source = source(device, site, "s3dc", decoder.as_ref());
        let draw = |brightness: &[f32]| -> Result<Image, EngineError> {
            let plan = plan(&view, decoder.layout(), brightness).unwrap();
            let drawing = Drawing::new(device, &plan, &source, view.filter)?;
            drawing.draw_timed()?;
            drawing.read_image()
        };
        let image = draw(&steps).unwrap();
        // Rays meet the same voxels as the raycaster's, and each shows a tinted entry of the palette.
        let mut found = [0; 4];
        for (pixel, seen) in image.pixels().iter().zip(seen.pixels()) {
            assert!(pixel[3] > 0.0 || seen[3] < 1e-3);
            if pixel[3] > 0.0 {
                let entry = ((pixel[3] * 4.0) as usize).min(3);
                found[entry] += 1;
                assert_eq!(pixel[..3], TINT.map(|channel| channel * steps[entry]));
            }
        }
        assert!(found.iter().sum::<usize>() > 100, "{found:?}");
        // The twin: another palette is another picture.
        assert!(draw(&[1.0; 4]).unwrap() != image);
    }
}

#[test]
fn what_its_author_forgets_is_named() {
    let Some(device) = test_device("own_renderer::errors") else { return };
    let volume = textured([9; 3], [1.0; 3], SampleType::U8);
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &volume);
    let view = view(SampleType::U8, [8, 8], Filter::Nearest);
    let source = source(device, Site::Inline, "raw", decoder.as_ref());
    let refused = |change: &dyn Fn(&mut Pass)| {
        let mut plan = plan(&view, decoder.layout(), &[1.0]).unwrap();
        change(&mut plan.passes[0]);
        Drawing::new(device, &plan, &source, view.filter).unwrap_err().to_string()
    };
    let error = refused(&|pass| {
        let source = BRIGHTEST.source.replace("classify(", "classified(");
        pass.pipeline.modules = vec![Template { source: source.leak(), ..BRIGHTEST }.into()];
    });
    assert!(error.contains("`classified`") && error.contains("brightest/brightest.wgsl:7:"), "{error}");
    let error = refused(&|pass| pass.pipeline.variables.retain(|variable| variable.name() != "brightness"));
    assert!(error.contains("`brightness`") && error.contains("brightest/brightest.wgsl:12:"), "{error}");
    let error = refused(&|pass| pass.inputs.contents.retain(|contents| contents.name != "palette"));
    assert!(error.contains("the shader reads `palette`, which the plan lacks"), "{error}");
    let error = refused(&|pass| {
        pass.inputs.contents.push(Contents { name: "palette", bytes: vec![0; 12] });
        pass.inputs.contents.swap_remove(2);
    });
    assert!(error.contains("`palette` has 12 bytes, and its struct in the shader 16"), "{error}");
}
