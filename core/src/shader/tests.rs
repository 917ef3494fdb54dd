use cvr_shaders as shaders;

use super::*;
use crate::codec::{Constant, ConstantValue, DecodedForm, WgslModule};
use crate::render::{Filter, Pipeline, RayWalk, SegmentSearch, Stage, Template};
use crate::volume::{Axis, Extent, FrameIndex, Level, SampleType, VolumeLayout};

const SNIPPET: &str = "\
fn toy_fetch(p: vec3<i32>) -> vec4<f32> {
    let i = u32(p.x) + toy_edge * (u32(p.y) + toy_edge * u32(p.z));
    return vec4<f32>(f32(toy_data(i)), 0.0, 0.0, 0.0);
}
";

fn layout() -> VolumeLayout {
    VolumeLayout::scalar(Extent::cube(8).unwrap(), SampleType::U8)
}

fn inline(
    snippet: &str,
    filter: Option<Filter>,
    program: &Program,
    words: u64,
) -> Result<GeneratedShader, ShaderError> {
    let limits = BindingLimits { storage_words: 1000, storage_buffers: 8 };
    let constants = vec![Constant { name: "edge", value: ConstantValue::U32(8) }];
    generate(&Request {
        program,
        layout: &layout(),
        source: Source::Inline {
            codec: "toy",
            module: WgslModule { file: "toy/decode.wgsl", source: snippet, constants },
            resources: vec![ResourceSize { name: "data", words }],
            frame: FrameIndex::FIRST,
            level: Level::FULL,
        },
        filter,
        limits,
    })
}

/// A small renderer: it shows the first sample of a ray.
const FIRST_SAMPLE: Template = Template {
    file: "shaders/first/first.wgsl",
    source: "\
fn gather(so_far: vec4<f32>, x: vec3<f32>, direction: vec3<f32>, piece: f32) -> Gathered {
    let sample = optical(x, direction);
    return Gathered(vec4<f32>(sample.rgb * opacity_over(sample.a, piece), 1.0), true);
}
",
};

/// A picture by that renderer, unlit and without a clip box.
fn picture() -> Program {
    let function = transfer_segments(SegmentSearch::Every { points: 2 });
    let offered = [
        shaders::CAMERA_PERSPECTIVE,
        shaders::BOUNDS_WHOLE,
        shaders::OPTICS_UNLIT,
        shaders::EVERY_SAMPLE,
        shaders::CLASSIFY_SCALAR,
    ];
    let pipeline = Pipeline {
        stage: Stage::Rays(RayWalk::default()),
        modules: vec![FIRST_SAMPLE.into()],
        offered: offered.into_iter().map(Module::from).chain([function]).collect(),
        variables: vec![
            Variable::Uniform { name: "view", wgsl_type: "View" },
            Variable::Table { name: "transfer_table", rows: 3 },
        ],
    };
    pipeline.program()
}

fn dump(snippet: &str) -> Result<GeneratedShader, ShaderError> {
    inline(snippet, None, &Program::dump(shaders::DUMP), 512)
}

#[test]
fn a_dump_shader_is_what_it_should_be() {
    insta::assert_snapshot!(dump(SNIPPET).unwrap().wgsl);
}

#[test]
fn texture_shaders_hold_no_more_than_they_need() {
    let form = DecodedForm::FLOAT32;
    let picture = picture();
    let of = |padded, sampling, filter| {
        generate(&Request {
            program: &picture,
            layout: &layout(),
            source: Source::Texture { form, sampling, padded },
            filter: Some(filter),
            limits: BindingLimits::default(),
        })
    };
    let make = |sampling, filter| of(None, sampling, filter);
    let hardware = make(TextureSampling::Hardware, Filter::Linear).unwrap();
    assert!(!hardware.wgsl.contains("voxel_fetch"));
    assert!(hardware.bindings.iter().any(|b| b.kind == BindingKind::VolumeSampler));
    let manual = make(TextureSampling::Manual, Filter::Linear).unwrap();
    assert!(manual.wgsl.contains("fn trilinear") && !manual.wgsl.contains("sampler"));
    let nearest = make(TextureSampling::Hardware, Filter::Nearest).unwrap();
    assert!(!nearest.wgsl.contains("trilinear") && !nearest.wgsl.contains("sampler"));
    assert!(make(TextureSampling::Hardware, Filter::OptimisedLinear).is_err());
    assert!(!hardware.wgsl.contains("clamp(x"), "the sampler clamps");
    let padded = of(Some([16, 8, 5]), TextureSampling::Hardware, Filter::Linear).unwrap();
    assert!(padded.wgsl.contains("const texture_size = vec3<u32>(16u, 8u, 5u);"));
    assert!(padded.wgsl.contains("clamp(x, vec3<f32>(0.5), vec3<f32>(volume_extent) - 0.5)"));
    let nearest = of(Some([16, 8, 5]), TextureSampling::Hardware, Filter::Nearest).unwrap();
    assert!(!nearest.wgsl.contains("texture_size"), "texels are where voxels are");
}

#[test]
fn a_large_buffer_is_split_and_the_snippet_cannot_tell() {
    let shader = inline(SNIPPET, Some(Filter::Linear), &picture(), 2500).unwrap();
    let parts: Vec<_> = shader.bindings.iter().filter(|b| b.group == 1).collect();
    assert_eq!(parts.len(), 3);
    assert_eq!(parts[2].kind, BindingKind::Words { resource: 0, first: 2000, words: 500 });
    assert!(shader.wgsl.contains("    if i < 2000u {\n        return toy_data_part1[i - 1000u];"));
    let error = inline(SNIPPET, Some(Filter::Linear), &picture(), 8000).unwrap_err().to_string();
    assert!(error.contains("needs 9 storage buffers") && error.contains("binds 8"), "{error}");
}

#[test]
fn a_level_is_written_only_where_it_is_asked_for() {
    assert!(!dump(SNIPPET).unwrap().wgsl.contains("toy_stages"));
    let asks = SNIPPET.replace("f32(toy_data(i))", "f32(toy_data(i) + toy_stages())");
    assert!(dump(&asks).unwrap().wgsl.contains("fn toy_stages() -> u32 {\n    return 255u;"));
}

#[test]
fn a_syntax_error_names_the_snippets_own_line() {
    let broken = SNIPPET.replace("* u32(p.z))", "* u32(p.z)");
    insta::assert_snapshot!(dump(&broken).unwrap_err());
}

#[test]
fn a_type_error_names_the_snippets_own_line() {
    let broken = SNIPPET.replace("f32(toy_data(i))", "toy_data(i)");
    insta::assert_snapshot!(dump(&broken).unwrap_err());
}

#[test]
fn an_unknown_resource_names_the_snippets_own_line() {
    let broken = SNIPPET.replace("toy_data(i)", "toy_codes(i)");
    insta::assert_snapshot!(dump(&broken).unwrap_err());
}

#[test]
fn a_wrong_signature_is_shown_with_the_contract() {
    let broken = SNIPPET
        .replace("-> vec4<f32> {", "-> f32 {")
        .replace("vec4<f32>(f32(toy_data(i)), 0.0, 0.0, 0.0)", "1.0");
    // The text must still parse, else the lint does not run. Here nothing calls the function.
    let error = dump(&broken).unwrap_err();
    insta::assert_snapshot!(error);
}

#[test]
fn a_missing_function_is_named() {
    insta::assert_snapshot!(dump("fn toy_other() {}\n").unwrap_err());
}

#[test]
fn a_missing_cell_function_is_named() {
    let error = inline(SNIPPET, Some(Filter::OptimisedLinear), &picture(), 512).unwrap_err();
    insta::assert_snapshot!(error);
}

#[test]
fn names_without_the_prefix_are_refused() {
    insta::assert_snapshot!(
        dump(&format!("{SNIPPET}\nfn classify(x: u32) -> u32 {{ return x; }}\n")).unwrap_err()
    );
}

#[test]
fn everything_else_that_breaks_the_contract_is_refused() {
    let cases = [
        ("alias word = u32;", "does not begin with `toy_`"),
        ("struct Cell { a: u32 }", "does not begin with `toy_`"),
        ("const toys = 3u;", "does not begin with `toy_`"),
        ("@group(2) @binding(0) var<storage, read> toy_x: array<u32>;", "no `@group`"),
        ("var<private> toy_state: u32;", "no variables at module scope"),
        ("@compute @workgroup_size(1) fn toy_main() {}", "no `@compute`"),
        ("/* quiet /* nested */ */ enable f16;", "no `enable` directive"),
        ("fn toy_p(x: f32) -> f32 { return pow(x, 2.2); }", "does not use `pow`"),
        ("fn toy_u(x: u32) -> f32 { return unpack4x8unorm(x).x; }", "does not use `unpack4x8unorm`"),
        (
            "fn toy_d(i: u32) -> u32 { return toy_data_part0[i]; }",
            "does not touch the binding `toy_data_part0`",
        ),
    ];
    for (line, expected) in cases {
        let error = dump(&format!("{SNIPPET}{line}\n")).unwrap_err().to_string();
        assert!(error.contains(expected), "{line}\n{error}");
        assert!(error.contains("toy/decode.wgsl:5:"), "wrong place:\n{error}");
    }
    // A comment may mention forbidden words.
    dump(&format!("// @group pow\n/* var<private> x */\n{SNIPPET}")).unwrap();
}

fn decode(channels: u32, format: crate::codec::TexelFormat) -> String {
    layers(channels, format, Axis::Z)
}

fn layers(channels: u32, format: crate::codec::TexelFormat, axis: Axis) -> String {
    let constants = vec![Constant { name: "edge", value: ConstantValue::U32(8) }];
    let source = Source::Inline {
        codec: "toy",
        module: WgslModule { file: "toy/decode.wgsl", source: SNIPPET, constants },
        resources: vec![ResourceSize { name: "data", words: 512 }],
        frame: FrameIndex::FIRST,
        level: Level::FULL,
    };
    let layout = VolumeLayout { channels, ..layout() };
    let shader = generate_decode(&source, &layout, (format, axis), BindingLimits::default()).unwrap();
    let kinds: Vec<_> = shader.bindings.into_iter().map(|b| (b.group, b.kind)).collect();
    let words = BindingKind::Words { resource: 0, first: 0, words: 512 };
    let slab = BindingKind::Uniforms(vec![UniformMember { name: "slab", offset: 0, bytes: 32 }]);
    let texels = BindingKind::Storage { name: "texels", written: true };
    assert_eq!(kinds, [(0, slab), (0, texels), (1, words)]);
    shader.wgsl
}

#[test]
fn a_decode_pass_is_what_it_should_be() {
    use crate::codec::TexelFormat::{Float16, Float32, Unorm8, Unorm16};
    insta::assert_snapshot!(decode(1, Unorm8));
    for format in [Unorm8, Unorm16, Float16, Float32] {
        let [scalar, colour] = [1, 3].map(|channels| decode(channels, format));
        assert!(scalar.contains(&format!("const texel_bits: u32 = {}u;", 8 * format.bytes())));
        assert!(colour.contains("alias Voxel = vec3<f32>;"));
        assert_eq!(voxels_per_invocation(format, 1) as usize, 4 / format.bytes());
        assert_eq!(voxels_per_invocation(format, 3), 1);
    }
}

#[test]
fn places_in_layers_follow_their_axis() {
    let place = |axis| {
        let text = layers(1, crate::codec::TexelFormat::Float32, axis);
        let (_, after) =
            text.split_once("fn voxel_of_layer(p: vec3<i32>) -> vec3<i32> {\n    return p.").unwrap();
        after[..3].to_owned()
    };
    assert_eq!(Axis::ALL.map(place), ["zxy", "xzy", "xyz"]);
}

/// Ring slots are read by the texture unit or by single texels. Only the accessors that the filter needs are written.
#[test]
fn a_ring_is_sampled_around_its_third_axis() {
    let form = DecodedForm::FLOAT32;
    let picture = picture();
    let make = |sampling, filter, axis| {
        generate(&Request {
            program: &picture,
            layout: &layout(),
            source: Source::Ring { form, sampling, axis },
            filter: Some(filter),
            limits: BindingLimits::default(),
        })
    };
    let hardware = make(TextureSampling::Hardware, Filter::Linear, Axis::X).unwrap();
    assert!(hardware.wgsl.contains("fn layered(p: vec3<f32>) -> vec3<f32> {\n    return p.yzx;"));
    assert!(!hardware.wgsl.contains("voxel_fetch") && !hardware.wgsl.contains("layered_voxel"));
    assert!(hardware.bindings.iter().any(|b| b.kind == BindingKind::RingSampler));
    for (sampling, filter) in [
        (TextureSampling::Manual, Filter::Linear),
        (TextureSampling::Manual, Filter::Nearest),
        (TextureSampling::Hardware, Filter::Nearest),
    ] {
        let manual = make(sampling, filter, Axis::Y).unwrap();
        assert!(manual.wgsl.contains("fn layered_voxel(p: vec3<i32>) -> vec3<i32> {\n    return p.xzy;"));
        assert!(manual.wgsl.contains("const ring_layers: i32 = 4;"));
        assert!(!manual.wgsl.contains("sampler") && !manual.wgsl.contains("fn layered("));
    }
    assert!(make(TextureSampling::Hardware, Filter::OptimisedLinear, Axis::Z).is_err());
}

/// A source of buffers brings its own modules, and only they read voxels.
#[test]
fn modules_fetch_voxels_from_buffers_of_their_own() {
    let picture = picture();
    let fetch = "fn voxel_fetch(p: vec3<i32>) -> Voxel {
    return voxel_of(vec4<f32>(f32(flat_words(u32(p.x) % flat_edge))));
}";
    let modules = [Template { file: "shaders/source/flat.wgsl", source: fetch }];
    let make = |words, filter, limits| {
        generate(&Request {
            program: &picture,
            layout: &layout(),
            source: Source::Buffers {
                name: "flat",
                modules: &modules,
                constants: vec![Constant { name: "edge", value: ConstantValue::U32(8) }],
                buffers: vec![ResourceSize { name: "words", words }],
            },
            filter: Some(filter),
            limits,
        })
    };
    let limits = BindingLimits { storage_words: 1000, storage_buffers: 8 };
    for filter in [Filter::Nearest, Filter::Linear] {
        let shader = make(1500, filter, limits).unwrap();
        assert!(shader.wgsl.contains("const flat_edge: u32 = 8u;"));
        let words = |first, words| BindingKind::Words { resource: 0, first, words };
        let kinds: Vec<_> = shader.bindings.into_iter().filter(|b| b.group == 1).map(|b| b.kind).collect();
        assert_eq!(kinds, [words(0, 1000), words(1000, 500)]);
    }
    assert!(make(8, Filter::OptimisedLinear, limits).is_err());
    let error = make(8000, Filter::Linear, limits).unwrap_err().to_string();
    assert!(error.contains("`flat`") && error.contains("needs 9 storage buffers"), "{error}");
}

#[test]
fn the_nearest_filter_breaks_ties_as_its_mirror_does() {
    let constant = format!("const nearest_tie: f32 = {:?};", Filter::NEAREST_TIE);
    assert!(shaders::FILTER_NEAREST.source.contains(&constant), "{constant}");
}

#[test]
fn uniforms_share_one_buffer_and_only_what_is_used_is_declared() {
    let lit = |offered: &[Template]| {
        let mut program = picture();
        program.offered.retain(|module| *module != shaders::OPTICS_UNLIT.into());
        program.offered.extend(offered.iter().map(|template| Module::from(*template)));
        program.variables.push(Variable::Uniform { name: "lighting", wgsl_type: "Lighting" });
        program.variables.push(Variable::read("macrocells", "array<u32>"));
        inline(SNIPPET, Some(Filter::Nearest), &program, 512).unwrap()
    };
    let uniforms = |shader: &GeneratedShader| {
        let kinds = shader.bindings.iter().map(|binding| binding.kind.clone());
        kinds.filter(|kind| matches!(kind, BindingKind::Uniforms(_))).collect::<Vec<_>>()
    };
    let view = UniformMember { name: "view", offset: 0, bytes: 128 };
    let unlit = lit(&[shaders::OPTICS_UNLIT]);
    assert_eq!(uniforms(&unlit), [BindingKind::Uniforms(vec![view])]);
    assert!(!unlit.wgsl.contains("macrocells"));
    let lit = lit(&[shaders::OPTICS_LIT, shaders::GRADIENT, shaders::HEIGHT_SCALAR]);
    let lighting = UniformMember { name: "lighting", offset: 128, bytes: 32 };
    assert_eq!(uniforms(&lit), [BindingKind::Uniforms(vec![view, lighting])]);
    assert!(lit.wgsl.contains("    @align(16) lighting: Lighting,\n"));
}

#[test]
fn equal_requests_have_equal_drafts() {
    let of = |words| {
        let program = picture();
        let constants = vec![Constant { name: "edge", value: ConstantValue::U32(8) }];
        draft(&Request {
            program: &program,
            layout: &layout(),
            source: Source::Inline {
                codec: "toy",
                module: WgslModule { file: "toy/decode.wgsl", source: SNIPPET, constants },
                resources: vec![ResourceSize { name: "data", words }],
                frame: FrameIndex::FIRST,
                level: Level::FULL,
            },
            filter: Some(Filter::Nearest),
            limits: BindingLimits::default(),
        })
        .unwrap()
    };
    assert_eq!(of(512), of(512));
    assert_ne!(of(512), of(513), "a buffer of another size is another binding");
}
