//! Rounds of loops of a picture. llvmpipe ends all loops of a thread after 65 535 in sum, and longer rays are followed
//! in pieces. A shader with its decoder in a loop must not need more rounds than one with copies of the decoder.

use cvr_core::render::{Camera, ControlPoint, Filter, Shading, Stage, TransferFunction, View};
use cvr_core::shader::Module;
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};
use cvr_engine::Drawing;
use cvr_engine::testing::test_device;
use cvr_shaders::FOLLOW_RAYS;

use super::scenes::inline;
use super::subjects::{codec, encoded, settings};

/// Rounds after which llvmpipe ends loops.
const MOST: f32 = 65535.0;

/// The end of a ray that was followed at once, and its replacement: red is then the number of remaining rounds.
const END: &str = "    return Walk(result, select(ray_end, i, more));";
const COUNTED: &str = "    var left = 0u;
    while left * inputs.view.size.x < 70000u * inputs.view.size.x {
        left += 1u;
    }
    return Walk(vec4<f32>(f32(left), f32(i), result.a, 1.0), ray_end);";

struct Subject {
    codec: &'static str,
    settings: &'static [(&'static str, &'static str)],
    channels: u32,
    filter: Filter,
    lit: bool,
    step_voxels: f32,
    /// Most rounds of a pixel if every fetch is a copy of the decoder (commit 0055078).
    copied: f32,
}

/// Waves with a little noise.
fn waves(channels: u32) -> FiniteVolume {
    let size = [9, 7, 5];
    let extent = Extent::try_from(size).unwrap();
    let layout = VolumeLayout { channels, ..VolumeLayout::scalar(extent, SampleType::U8) };
    let value = |i: u32| {
        let (v, c) = (i / channels, f64::from(i % channels));
        let [x, y, z] = [v % size[0], v / size[0] % size[1], v / (size[0] * size[1])].map(f64::from);
        let waves = (0.31 * x + 0.1 * z + c).sin() * (0.27 * y - 0.2 * x).cos() * (0.25 * z + 0.4).sin();
        let noise = f64::from(i.wrapping_mul(2_654_435_761) >> 24) / 255.0 - 0.5;
        (127.0 + 110.0 * waves + 30.0 * noise).clamp(0.0, 255.0) as u8
    };
    let samples = Samples::U8((0..layout.samples() as u32).map(value).collect());
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

fn view(subject: &Subject) -> View {
    let point = |value, rgba| ControlPoint { value, rgba };
    let points = vec![
        point(0.0, [0.1, 0.1, 0.8, 0.0]),
        point(100.0, [0.1, 0.4, 0.8, 0.01]),
        point(127.0, [0.9, 0.7, 0.2, 0.1]),
        point(255.0, [1.0, 0.9, 0.8, 0.2]),
    ];
    View {
        size: [16; 2],
        camera: Camera { zoom: 1.2, ..Camera::default() },
        filter: subject.filter,
        step_voxels: subject.step_voxels,
        shading: subject.lit.then(Shading::default),
        ..View::new(TransferFunction::new(points).unwrap())
    }
}

fn subjects() -> Vec<Subject> {
    const VARIABLE: &[(&str, &str)] = &[("payload", "variable"), ("rate", "0.5")];
    const ZFP: &[(&str, &str)] = &[("rate", "8")];
    use Filter::{Linear, Nearest, OptimisedLinear};
    let of = |codec, settings, (channels, filter, lit), step_voxels, copied| Subject {
        codec,
        settings,
        channels,
        filter,
        lit,
        step_voxels,
        copied,
    };
    let light = ["raw", "s3dc", "bc4", "vq", "hvq", "tvq"].into_iter().flat_map(|codec| {
        [(false, 23.0), (true, 100.0)].map(|(lit, copied)| of(codec, &[], (1, Linear, lit), 0.5, copied))
    });
    light
        .chain([
            of("tvq", VARIABLE, (1, Linear, false), 0.5, 343.0),
            of("tvq", VARIABLE, (3, Linear, false), 0.5, 1871.0),
            of("tvq", VARIABLE, (1, Linear, true), 0.5, 2884.0),
            of("tvq", VARIABLE, (3, Linear, true), 0.5, 13852.0),
            of("tvq", VARIABLE, (1, OptimisedLinear, true), 0.5, 1666.0),
            of("zfp", ZFP, (1, Nearest, false), 0.5, 1075.0),
            of("zfp", ZFP, (1, Nearest, true), 0.5, 7435.0),
            of("zfp", ZFP, (1, OptimisedLinear, true), 0.5, 24495.0),
            of("zfp", ZFP, (1, Linear, false), 0.5, 8398.0),
            of("zfp", ZFP, (3, Linear, false), 0.5, 23594.0),
            of("zfp", ZFP, (1, Linear, true), 1.0, 30317.0),
        ])
        .collect()
}

#[test]
fn a_decoder_in_a_loop_takes_no_more_rounds_than_its_copies() {
    let Some(device) = test_device("rounds") else { return };
    if !device.info().to_string().contains("llvmpipe") {
        println!("no rounds to count: {} ends no loops", device.info());
        return;
    }
    let mut more = Vec::new();
    for subject in subjects() {
        let Subject { codec: id, settings: pairs, channels, filter, lit, copied, .. } = subject;
        let decoder = encoded(codec(id).as_ref(), &settings(pairs), &waves(channels));
        let renderer = cvr::registry::renderer("raycasting").unwrap();
        let mut plan = renderer.plan(&view(&subject), decoder.layout()).unwrap();
        let [pass] = &mut plan.passes[..] else { panic!("one pass") };
        let mut program = pass.pipeline.program();
        let walk = program.modules.iter_mut().find(|m| **m == FOLLOW_RAYS.into()).unwrap();
        assert!(walk.source().contains(END), "the module has changed: it holds no `{END}`");
        let source = walk.source().replace(END, COUNTED);
        *walk = Module::Generated { purpose: "rays whose rounds are counted", source };
        pass.pipeline.modules = program.modules;
        pass.pipeline.stage = Stage::Compute { entry: program.entry };
        pass.inputs.workgroups = [2, 2, 1];
        let drawing = Drawing::new(device, &plan, &inline(id, decoder.as_ref()), filter).unwrap();
        drawing.draw_timed().unwrap();
        let picture = drawing.read_image().unwrap();
        let left = picture.pixels().iter().map(|pixel| pixel[0]).reduce(f32::min).unwrap();
        let rounds = MOST - left;
        println!("{id} {pairs:?} {channels} {filter}, lit {lit}: {rounds}, copied {copied}");
        assert!((3.0..MOST).contains(&rounds), "{id}: {rounds} rounds");
        if rounds > copied {
            more.push(format!("{id} {pairs:?} {channels} {filter}, lit {lit}: {rounds} > {copied}"));
        }
    }
    assert!(more.is_empty(), "{}", more.join("\n"));
}
