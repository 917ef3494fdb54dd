use std::sync::Arc;

use cvr_core::codec::{Constant, ConstantValue, DecodedForm, Decoder, Resource, TexelFormat};
use cvr_core::render::{Contents, Inputs, LayerStep, Pass, Proxies, ProxyVertex, Stage, Template};
use cvr_core::shader::Variable;
use cvr_core::volume::{Axis, FrameIndex, Level};

use super::*;
use crate::testing::{another_device, test_device};
use crate::toy::Toy;
use crate::{VolumeBuffers, VolumeTexture};

/// Paints slice `view.z` of the volume, one pixel per voxel, tinted by the first entry of the table.
const PAINT: Template = Template {
    file: "shaders/paint.wgsl",
    source: "\
struct View { size: vec2<u32>, z: f32, unused: vec4<f32> }
@compute @workgroup_size(8, 8)
fn paint(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = inputs.view;
    if id.x >= view.size.x || id.y >= view.size.y { return; }
    let value = volume_sample(vec3<f32>(vec2<f32>(id.xy) + 0.5, view.z));
    image[id.y * view.size.x + id.x] = vec4<f32>(value, textureLoad(transfer_table, vec2<u32>(0u), 0).xyz);
}
",
};

const TINT: [f32; 4] = [0.25, 0.5, 0.75, 1.0];

fn plan(size: [u32; 2], z: f32) -> Plan {
    let mut view: Vec<u8> = size.iter().flat_map(|v| v.to_le_bytes()).collect();
    view.extend(z.to_le_bytes());
    view.resize(32, 0);
    let pipeline = Pipeline {
        stage: Stage::Compute { entry: "paint" },
        modules: vec![PAINT.into()],
        offered: Vec::new(),
        variables: vec![
            Variable::Uniform { name: "view", wgsl_type: "View" },
            Variable::Table { name: "transfer_table", rows: 3 },
        ],
    };
    let inputs = Inputs {
        contents: vec![
            Contents { name: "view", bytes: view },
            Contents { name: "transfer_table", bytes: bytemuck::cast_slice(&[TINT; 3]).to_vec() },
        ],
        workgroups: [size[0].div_ceil(8), size[1].div_ceil(8), 1],
        ..Inputs::default()
    };
    Plan { size, passes: vec![Pass { pipeline, inputs }] }
}

fn inline(toy: &Toy) -> DrawSource<'_> {
    DrawSource::Inline { codec: "toy", decoder: toy, frame: FrameIndex::FIRST, level: Level::FULL }
}

fn texture(device: &Device, toy: &Toy) -> VolumeTexture {
    VolumeTexture::upload(device, &toy.layout, &toy.values(), toy.decoded_form()).unwrap()
}

/// Mean of two slices, pixel by pixel.
fn expect(toy: &Toy, slices: [usize; 2], image: &Image, tolerance: f32) {
    let values = toy.values();
    let area = image.pixels().len();
    for (i, pixel) in image.pixels().iter().enumerate() {
        let want = (values[slices[0] * area + i] + values[slices[1] * area + i]) / 2.0;
        assert!((pixel[0] - want).abs() <= tolerance, "pixel {i}: {} for {want}", pixel[0]);
        assert_eq!(pixel[1..], TINT[..3]);
    }
}

/// The values of a toy, last voxel first.
fn buffers(toy: &Toy) -> DrawSource<'static> {
    const FETCH: Template = Template {
        file: "shaders/reversed.wgsl",
        source: "\
fn voxel_fetch(p: vec3<i32>) -> Voxel {
    let v = vec3<u32>(p);
    let i = (v.z * volume_extent.y + v.y) * volume_extent.x + v.x;
    return voxel_of(vec4<f32>(f32(reversed_words(reversed_last - i))));
}
",
    };
    let last = toy.words.len() as u32 - 1;
    DrawSource::Buffers(Arc::new(VolumeBuffers {
        layout: toy.layout.clone(),
        name: "reversed",
        modules: &[FETCH],
        constants: vec![Constant { name: "last", value: ConstantValue::U32(last) }],
        buffers: vec![Resource {
            name: "words",
            words: toy.words.iter().rev().copied().collect::<Vec<_>>().into(),
        }],
    }))
}

#[test]
fn all_sources_and_filters_paint_the_same_slice() {
    let Some(device) = test_device("drawing::sources_and_filters") else { return };
    let toy = Toy::new([13, 17, 5], 1);
    let texture = texture(device, &toy);
    let choice = texture.choice();
    let manual = DrawSource::Texture(Arc::new(texture.with_manual_sampling()));
    let texture = DrawSource::Texture(Arc::new(texture));
    // Between slices 1 and 2 (z = 2), interpolation gives half of each. The texture unit has 8-bit weights.
    for (source, filter, z, slices, tolerance) in [
        (inline(&toy), Filter::Nearest, 2.9, [2, 2], 0.0),
        (inline(&toy), Filter::Linear, 2.0, [1, 2], 0.01),
        (inline(&toy), Filter::OptimisedLinear, 2.0, [1, 2], 0.01),
        (buffers(&toy), Filter::Nearest, 2.9, [2, 2], 0.0),
        (buffers(&toy), Filter::Linear, 2.0, [1, 2], 0.01),
        (texture.clone(), Filter::Nearest, 2.9, [2, 2], 0.01),
        (manual, Filter::Linear, 2.0, [1, 2], 0.01),
        (texture, Filter::Linear, 2.0, [1, 2], 65535.0 / 255.0),
    ] {
        let drawing = Drawing::new(device, &plan([13, 17], z), &source, filter).unwrap();
        assert_eq!(drawing.read_image().unwrap(), Image::new([13, 17]), "nothing is drawn yet");
        let by_texture_unit = matches!(&source, DrawSource::Texture(t) if t.choice() == choice);
        let hardware = by_texture_unit && filter == Filter::Linear;
        assert_eq!(drawing.filtering() == TextureSampling::Hardware, hardware);
        drawing.draw_timed().unwrap();
        expect(&toy, slices, &drawing.read_image().unwrap(), tolerance);
    }
}

/// Shows cell 1 of a stack, between its layers 1 and 2, one pixel per voxel of a layer.
const CELL: Template = Template {
    file: "shaders/cell.wgsl",
    source: "\
struct Proxy { @builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) cell: u32 }
@vertex
fn corner(
    @location(0) position: vec2<f32>,
    @location(1) slice: u32,
    @builtin(instance_index) instance: u32,
) -> Proxy {
    return Proxy(vec4<f32>(position, 0.0, 1.0), instance);
}
fn shown(corner: Proxy) -> vec4<f32> {
    let x = vec3<f32>(corner.position.xy, f32(corner.cell));
    let value = volume_sample(back(x));
    let next = volume_sample(back(x + vec3<f32>(0.0, 0.0, 1.0)));
    return vec4<f32>(value, next, layered(back(x)).z, 1.0);
}
",
};

const BACK: [Template; 3] = [
    Template { file: "x.wgsl", source: "fn back(p: vec3<f32>) -> vec3<f32> { return p.zxy; }" },
    Template { file: "y.wgsl", source: "fn back(p: vec3<f32>) -> vec3<f32> { return p.xzy; }" },
    Template { file: "z.wgsl", source: "fn back(p: vec3<f32>) -> vec3<f32> { return p; }" },
];

/// A ring of layers, filtered by the texture unit and by the shader. Layers 4 and 5 reuse slots.
#[test]
fn a_ring_holds_its_layers_whoever_filters() {
    let Some(device) = test_device("drawing::ring") else { return };
    // Values of nine bits in half-precision texels. They and their means are exact in pictures of either precision.
    let words = (0..9 * 8 * 7).map(|i| i * 211 % 509 * 128).collect();
    let form = DecodedForm { format: TexelFormat::Float16, scale: 1.0, offset: 0.0 };
    let toy = Toy { words, form, ..Toy::new([9, 8, 7], 1) };
    let values = toy.values();
    for axis in Axis::ALL {
        let [width, height, layers] = axis.layered(toy.layout.extent.to_array());
        let corner = |x, y| ProxyVertex { position: [x, y], slice: 0 };
        let proxies = Proxies { vertex: "corner", blending: Blending::Float32 };
        let pipeline = Pipeline {
            stage: Stage::Layers { proxies, axis },
            modules: vec![CELL.into(), BACK[axis.index()].into()],
            offered: Vec::new(),
            variables: Vec::new(),
        };
        let place = |layer| [LayerStep::Decode(layer), LayerStep::Place(layer % 4)];
        let draw = |between| LayerStep::Draw { between, vertices: 0..3 };
        let steps =
            [[0, 1, 2, 3].map(place).concat(), vec![draw(0)], [4, 5].map(place).concat(), vec![draw(3)]];
        let inputs = Inputs {
            vertices: vec![corner(-1.0, -1.0), corner(3.0, -1.0), corner(-1.0, 3.0)],
            steps: steps.concat(),
            ..Inputs::default()
        };
        let plan = Plan { size: [width, height], passes: vec![Pass { pipeline, inputs }] };
        let source =
            DrawSource::Ring { codec: "toy", decoder: &toy, frame: FrameIndex::FIRST, level: Level::FULL };
        for (filter, manual) in [
            (Filter::Nearest, true),
            (Filter::Linear, true),
            (Filter::Linear, false),
            (Filter::Nearest, false),
        ] {
            let mut ring = ring_of(device, &plan, &source).unwrap().unwrap();
            if manual {
                ring = ring.with_manual_sampling();
            }
            let drawing = Drawing::from_ring(device, &plan, &source, filter, Some(ring)).unwrap();
            let hardware = !manual && filter == Filter::Linear;
            assert_eq!(drawing.filtering() == TextureSampling::Hardware, hardware);
            drawing.draw_timed().unwrap();
            let image = drawing.read_image().unwrap();
            let at = |i: usize, layer: u32| {
                let p = axis.unlayered([i as u32 % width, i as u32 / width, layer]);
                values[toy.layout.extent.index(p)]
            };
            // The second piece lies over the first: instance 4 lies between layers 3 and 4.
            for (i, pixel) in image.pixels().iter().enumerate() {
                let mean = |a, b| (at(i, a) + at(i, b)) / 2.0;
                let expected =
                    if filter == Filter::Nearest { [at(i, 4), at(i, 5)] } else { [mean(3, 4), mean(4, 5)] };
                let tolerance = if hardware { 65535.0 / 255.0 } else { 0.01 };
                for (got, want) in pixel.iter().zip(expected) {
                    assert!((got - want).abs() <= tolerance, "{axis:?} {filter} pixel {i}: {got} for {want}");
                }
                assert_eq!(pixel[2], 4.0);
            }
            assert_eq!(drawing.read_layers().unwrap().unwrap(), values, "{axis:?} of {layers} layers");
        }
    }
}

/// Other inputs are drawn without compiling. Another pipeline or size is refused.
#[test]
fn a_drawing_takes_other_inputs_and_compiles_nothing() {
    let Some(device) = test_device("drawing::other_inputs") else { return };
    // A separate device counts its own pipelines.
    let device = device.without_block_textures();
    let toy = Toy::new([13, 17, 5], 1);
    let new = |plan: &Plan| Drawing::new(&device, plan, &inline(&toy), Filter::Nearest).unwrap();
    let mut drawing = new(&plan([13, 17], 0.5));
    drawing.draw().unwrap();
    assert_eq!(device.pipelines_compiled(), 1);
    for (z, slice) in [(3.5, 3), (1.5, 1), (0.5, 0)] {
        let other = plan([13, 17], z);
        assert!(drawing.takes(&other));
        drawing.set_inputs(&other).unwrap();
        drawing.draw().unwrap();
        expect(&toy, [slice, slice], &drawing.read_image().unwrap(), 0.0);
    }
    // A table of another size needs another texture.
    let mut wide = plan([13, 17], 2.5);
    wide.passes[0].inputs.contents[1].bytes = bytemuck::cast_slice(&[TINT; 6]).to_vec();
    drawing.set_inputs(&wide).unwrap();
    drawing.draw().unwrap();
    expect(&toy, [2, 2], &drawing.read_image().unwrap(), 0.0);
    assert_eq!(device.pipelines_compiled(), 1, "another drawing of the same pipeline");
    new(&plan([7, 5], 0.5)).draw().unwrap();
    assert_eq!(device.pipelines_compiled(), 1, "whatever its size");

    let mut other = plan([13, 17], 0.5);
    other.passes[0].pipeline.modules.push(BACK[0].into());
    for refused in [other.clone(), plan([13, 16], 0.5)] {
        assert!(!drawing.takes(&refused));
        let error = drawing.set_inputs(&refused).unwrap_err();
        assert!(
            matches!(&error, EngineError::Unsupported(text) if text.contains("another pipeline")),
            "{error}"
        );
    }
    new(&other).draw().unwrap();
    assert_eq!(device.pipelines_compiled(), 2);
    device.forget_pipelines();
    new(&other).draw().unwrap();
    assert_eq!(device.pipelines_compiled(), 3);
}

#[test]
fn resident_bytes_are_those_of_the_volume() {
    let Some(device) = test_device("drawing::resident_bytes") else { return };
    let toy = Toy::new([13, 17, 5], 1);
    let plan = plan([13, 17], 0.5);
    let drawing = Drawing::new(device, &plan, &inline(&toy), Filter::Linear).unwrap();
    assert_eq!(drawing.resident_bytes(), 13 * 17 * 5 * 4);
    assert!(drawing.wgsl().contains("toy_fetch"));
    let texture = Arc::new(texture(device, &toy));
    let source = DrawSource::Texture(Arc::clone(&texture));
    let drawing = Drawing::new(device, &plan, &source, Filter::Linear).unwrap();
    assert_eq!(drawing.resident_bytes(), texture.bytes());
}

#[test]
fn a_frame_has_its_times() {
    let Some(device) = test_device("drawing::times") else { return };
    let toy = Toy::new([64, 64, 4], 1);
    let drawing = Drawing::new(device, &plan([64, 64], 1.0), &inline(&toy), Filter::Linear).unwrap();
    for _ in 0..3 {
        let time = drawing.draw_timed().unwrap();
        assert!(time.wall_ms > 0.0);
        assert!(time.gpu_ms.is_none_or(|gpu| gpu > 0.0 && gpu <= time.wall_ms * 1.05));
        assert!(time.cpu_ms.is_none_or(|cpu| cpu >= 0.0));
        println!("{time:?}");
    }
}

#[test]
fn refusals_say_why() {
    let Some(device) = test_device("drawing::refusals") else { return };
    let toy = Toy::new([13, 17, 5], 1);
    let refuse = |plan: &Plan, source: &DrawSource<'_>| {
        Drawing::new(device, plan, source, Filter::Linear).unwrap_err()
    };
    let broken =
        Toy { snippet: "fn toy_fetch(p: vec3<i32>) -> vec4<f32> { return q; }", ..Toy::new([4; 3], 1) };
    let error = refuse(&plan([4, 4], 0.5), &inline(&broken));
    assert!(matches!(&error, EngineError::Shader(e) if e.0.contains("toy/decode.wgsl")), "{error}");

    assert!(matches!(refuse(&plan([0, 4], 0.5), &inline(&toy)), EngineError::Unsupported(_)));
    let error = refuse(&plan([1 << 20, 1 << 20], 0.5), &inline(&toy));
    assert!(matches!(error, EngineError::TooLarge { .. }), "{error}");

    let mut empty = plan([4, 4], 0.5);
    empty.passes.clear();
    assert!(matches!(refuse(&empty, &inline(&toy)), EngineError::Unsupported(_)));

    let mut wide = plan([4, 4], 0.5);
    wide.passes[0].inputs.workgroups[0] = u32::MAX;
    assert!(matches!(refuse(&wide, &inline(&toy)), EngineError::TooLarge { .. }));

    let mut blind = plan([4, 4], 0.5);
    blind.passes[0].inputs.contents[0].bytes.clear();
    assert!(matches!(refuse(&blind, &inline(&toy)), EngineError::Unsupported(_)));
}

#[test]
fn what_only_the_driver_can_refuse_is_an_error_too() {
    let Some(device) = test_device("drawing::driver_refusals") else { return };
    let toy = Toy::new([13, 17, 5], 1);
    const CROWD: Template = Template {
        file: "shaders/crowd.wgsl",
        source: "\
struct View { size: vec2<u32>, unused: vec4<u32> }
@compute @workgroup_size(8192)
fn paint() { image[0] = vec4<f32>(volume_sample(vec3<f32>(inputs.view.size.xyx))) + textureLoad(transfer_table, vec2<u32>(0u), 0); }
",
    };
    let mut crowd = plan([4, 4], 0.5);
    crowd.passes[0].pipeline.modules = vec![CROWD.into()];
    let error = Drawing::new(device, &crowd, &inline(&toy), Filter::Linear).unwrap_err();
    let EngineError::Gpu(text) = &error else { panic!("{error}") };
    assert!(text.contains("workgroup"), "{text}");

    // A buffer shorter than its array shows only when it is drawn.
    const LONG: Template = Template {
        file: "shaders/long.wgsl",
        source: "\
@compute @workgroup_size(1)
fn paint() { image[0] = vec4<f32>(volume_sample(vec3<f32>(numbers[99]))); }
",
    };
    let mut short = plan([4, 4], 0.5);
    short.passes[0].pipeline.modules = vec![LONG.into()];
    short.passes[0].pipeline.variables.push(Variable::read("numbers", "array<f32, 100>"));
    short.passes[0].inputs.contents.push(Contents { name: "numbers", bytes: vec![0; 16] });
    let drawing = Drawing::new(device, &short, &inline(&toy), Filter::Linear).unwrap();
    for _ in 0..2 {
        let error = drawing.draw_timed().unwrap_err();
        assert!(matches!(&error, EngineError::Gpu(text) if text.starts_with("drawing: ")), "{error}");
    }
}

#[test]
fn a_device_lost_between_frames_is_an_error_of_the_frame() {
    if test_device("drawing::lost_device").is_none() {
        return;
    }
    let device = another_device();
    let toy = Toy::new([13, 17, 5], 1);
    let drawing = Drawing::new(&device, &plan([13, 17], 0.5), &inline(&toy), Filter::Nearest).unwrap();
    drawing.draw_timed().unwrap();
    device.wgpu().destroy();
    assert!(matches!(drawing.draw_timed(), Err(EngineError::DeviceLost(_))));
    assert!(matches!(drawing.read_image(), Err(EngineError::DeviceLost(_))));
}
