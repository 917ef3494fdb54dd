//! The text of passes, their contract, and refusals.

use super::*;
use crate::codec::{Constant, ConstantValue, Resource, ScratchUse, TexelFormat, WgslModule};
use crate::render::Filter;
use crate::shader::{Binding, GeneratedShader, Program, Request, generate, generate_decode};
use crate::volume::{Axis, Extent, SampleType};

/// Adds the data, and turns every 64 words round.
const TURN: &str = "\
var<workgroup> toy_tile: array<u32, 64>;

@compute @workgroup_size(64)
fn toy_turn(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    toy_tile[local] = toy_from(id.x) + toy_data(id.x) * toy_factor;
    workgroupBarrier();
    toy_set_to(id.x, toy_tile[63u - local]);
}
";

fn layout(channels: u32) -> VolumeLayout {
    VolumeLayout { channels, ..VolumeLayout::scalar(Extent::cube(8).unwrap(), SampleType::U8) }
}

fn pass(source: &str) -> FramePass<'_> {
    let constants = vec![Constant { name: "factor", value: ConstantValue::U32(3) }];
    let module = WgslModule { file: "toy/turn.wgsl", source, constants };
    let scratch = vec![ScratchUse { name: "from", buffer: "a" }, ScratchUse { name: "to", buffer: "b" }];
    FramePass { module, entry: "turn", workgroups: [8, 1, 1], scratch }
}

fn passes(source: &str) -> FramePasses<'_> {
    let words = (0..512).collect::<Vec<u32>>().into();
    FramePasses {
        resources: vec![Resource { name: "data", words }, Resource { name: "more", words: vec![7].into() }],
        scratch: vec![Scratch { name: "a", words: 512 }, Scratch { name: "b", words: 2500 }],
        passes: vec![pass(source)],
        result: "b",
    }
}

const KEY: (FrameIndex, Level) = (FrameIndex::FIRST, Level::FULL);

fn limits(storage_words: u64) -> BindingLimits {
    BindingLimits { storage_words, storage_buffers: 8 }
}

fn generated(passes: &FramePasses<'_>) -> Result<GeneratedShader, ShaderError> {
    let (mut shaders, _) = generate_passes("toy", passes, &layout(1), KEY, limits(1000))?;
    Ok(shaders.remove(0).shader)
}

fn problem(passes: &FramePasses<'_>) -> String {
    generated(passes).unwrap_err().to_string()
}

#[test]
fn a_pass_is_what_it_should_be() {
    insta::assert_snapshot!(generated(&passes(TURN)).unwrap().wgsl);
}

#[test]
fn a_pass_binds_what_it_uses_and_writes_only_what_it_sets() {
    let kinds = |shader: GeneratedShader| {
        let of = |(i, Binding { group, binding, kind })| {
            assert_eq!((group, binding as usize), (1, i));
            kind
        };
        shader.bindings.into_iter().enumerate().map(of).collect::<Vec<_>>()
    };
    let part = |buffer, first, words, written| BindingKind::Scratch { buffer, first, words, written };
    // `more` and `toy_set_from` occur in comments only, which use nothing.
    let source = format!("// toy_more(0u), toy_set_from(0u, 1u)\n{TURN}");
    assert_eq!(
        kinds(generated(&passes(&source)).unwrap()),
        [
            BindingKind::Words { resource: 0, first: 0, words: 512 },
            part(0, 0, 512, false),
            part(1, 0, 1000, true),
            part(1, 1000, 1000, true),
            part(1, 2000, 500, true),
        ]
    );
    let in_place = "@compute @workgroup_size(1) fn toy_turn() { toy_set_from(0u, toy_from(1u)); }";
    let shader = generated(&passes(in_place)).unwrap();
    assert!(shader.wgsl.contains("var<storage, read_write> toy_from_part0"));
    assert_eq!(kinds(shader), [part(0, 0, 512, true)]);
    let nothing = "@compute @workgroup_size(1) fn toy_turn() {}";
    assert!(generated(&passes(nothing)).unwrap().bindings.is_empty());
}

#[test]
fn the_level_is_at_hand() {
    let source = TURN.replace("* toy_factor", "* toy_stages()");
    assert!(generated(&passes(&source)).unwrap().wgsl.contains("fn toy_stages() -> u32 {\n    return 255u;"));
}

#[test]
fn the_packing_pass_reads_the_result() {
    for (channels, format) in [(1, TexelFormat::Unorm8), (3, TexelFormat::Float32)] {
        let layout = layout(channels);
        let (_, source) = generate_passes("toy", &passes(TURN), &layout, KEY, limits(1000)).unwrap();
        let pack = generate_decode(&source, &layout, (format, Axis::Z), limits(1000)).unwrap();
        assert!(!pack.wgsl.contains("toy"), "the packing pass knows no codec");
        let scratch = pack.bindings.iter().filter(|b| matches!(b.kind, BindingKind::Scratch { .. }));
        let first = |b: &Binding| match b.kind {
            BindingKind::Scratch { buffer: 1, first, written: false, .. } => first,
            ref other => panic!("{other:?}"),
        };
        assert_eq!(scratch.map(first).collect::<Vec<_>>(), [0, 1000, 2000]);
        if channels == 1 {
            insta::assert_snapshot!(pack.wgsl);
        }
    }
}

/// Any template can take its voxels from a rebuilt frame. Only the fast path of a snippet is impossible.
#[test]
fn a_rebuilt_frame_is_a_source_like_others() {
    let (_, source) = generate_passes("toy", &passes(TURN), &layout(3), KEY, limits(5000)).unwrap();
    let make = |filter| {
        generate(&Request {
            program: &Program::dump(cvr_shaders::DUMP),
            layout: &layout(3),
            source: source.clone(),
            filter,
            limits: limits(5000),
        })
    };
    assert!(make(None).is_ok() && make(Some(Filter::Linear)).is_ok());
    let error = make(Some(Filter::OptimisedLinear)).unwrap_err().to_string();
    assert!(error.contains("has nothing to decode"), "{error}");
}

#[test]
fn a_broken_pass_names_its_own_line() {
    insta::assert_snapshot!(problem(&passes(&TURN.replace("id.x) + toy", "id.x) + * toy"))));
    // Types that do not fit, and a buffer that is not there.
    for (from, to, line) in [
        ("toy_tile[63u - local]", "f32(local)", 7),
        ("toy_data(id.x)", "toy_dta(id.x)", 5),
        ("toy_set_to(", "toy_set_out(", 7),
        ("toy_from(id.x)", "toy_from(f32(id.x))", 5),
    ] {
        let error = problem(&passes(&TURN.replace(from, to)));
        assert!(error.contains(&format!("toy/turn.wgsl:{line}:")), "{to}\n{error}");
    }
    let error = problem(&passes(&TURN.replace("toy_set_to(", "toy_set_out(")));
    assert!(error.contains("`toy_set_to(i: u32, word: u32)`") && error.contains("`toy_factor`"), "{error}");
}

#[test]
fn everything_that_breaks_the_contract_is_refused() {
    let cases = [
        ("fn classify(x: u32) -> u32 { return x; }", "`classify` does not begin with `toy_`"),
        ("var<workgroup> tile: u32;", "`tile` does not begin with `toy_`"),
        ("alias word = u32;", "does not begin with `toy_`"),
        ("var<private> toy_state: u32;", "no variables at module scope but those of its workgroup"),
        ("var<storage, read_write> toy_state: u32;", "no variables at module scope"),
        ("@group(0) @binding(9) var<storage> toy_x: array<u32>;", "a pass has no `@group`"),
        ("@binding(9) var<storage> toy_x: array<u32>;", "a pass has no `@binding`"),
        ("@vertex fn toy_v() -> @builtin(position) vec4<f32> { return vec4<f32>(); }", "no `@vertex`"),
        ("@fragment fn toy_v() {}", "a pass has no `@fragment`"),
        ("enable subgroups;", "no `enable` directive"),
        ("override toy_o: u32;", "a pass has no `override`"),
        ("@compute @workgroup_size(1) fn toy_other() {}", "`toy_other` is another"),
        ("fn toy_p(x: f32) -> f32 { return pow(x, 2.2); }", "a pass does not use `pow`"),
        ("fn toy_d() -> u32 { return toy_data_part0[0]; }", "touch the binding `toy_data_part0`"),
        ("fn toy_d() { toy_to_part0[0] = 1u; }", "touch the binding `toy_to_part0`"),
        ("fn toy_d() { toy_to_part0[toy_tile[0]] = 1u; }", "touch the binding `toy_to_part0`"),
    ];
    for (line, expected) in cases {
        let error = problem(&passes(&format!("{TURN}{line}\n")));
        assert!(error.contains(expected), "{line}\n{error}");
        assert!(error.contains("toy/turn.wgsl:9:"), "wrong place:\n{error}");
    }
    // In the entry point itself.
    let error = problem(&passes(&TURN.replace("toy_from(id.x)", "toy_from_part0[id.x]")));
    let unused = "no definition in scope";
    assert!(error.contains(unused) && error.contains("toy/turn.wgsl:5:"), "{error}");
    let error = problem(&passes(&TURN.replace("toy_from(id.x) +", "toy_from(1u) + toy_from_part0[id.x] +")));
    assert!(error.contains("binding `toy_from_part0`") && error.contains("toy/turn.wgsl:5:"), "{error}");
    let error = problem(&passes(&TURN.replace("toy_from(id.x)", "pack4x8unorm(vec4<f32>())")));
    assert!(error.contains("`pack4x8unorm`") && error.contains("toy/turn.wgsl:5:"), "{error}");
    // A comment may mention forbidden words.
    generated(&passes(&format!("// @group pow\n/* var<private> x */\n{TURN}"))).unwrap();
}

#[test]
fn a_pass_has_one_entry_point_that_every_device_can_run() {
    let cases = [
        (TURN.replace("fn toy_turn", "fn toy_trun"), "the pass declares no function `toy_turn`"),
        (TURN.replace("@compute @workgroup_size(64)\n", ""), "`toy_turn` is no entry point"),
        (TURN.replace("size(64)", "size(257)"), "257×1×1 is 257 invocations"),
        (TURN.replace("size(64)", "size(32, 16)"), "32×16×1 is 512 invocations"),
        (TURN.replace("size(64)", "size(1, 1, 65)"), "1×1×65 is 65 invocations"),
        (TURN.replace("u32, 64>", "u32, 4097>"), "take 16388 bytes"),
    ];
    for (source, expected) in cases {
        let error = problem(&passes(&source));
        assert!(error.contains(expected) && error.contains("toy/turn.wgsl:"), "{error}");
    }
    for size in ["256", "4, 1, 64", "16, 16", "4u * 16u"] {
        generated(&passes(&TURN.replace("size(64)", &format!("size({size})")))).unwrap();
    }
    generated(&passes(&TURN.replace("u32, 64>", "u32, 4096>"))).unwrap();
}

#[test]
fn passes_that_contradict_themselves_are_refused_with_names_and_numbers() {
    let refused = |change: &dyn Fn(&mut FramePasses<'_>), expected: &str| {
        let mut passes = passes(TURN);
        change(&mut passes);
        let error = problem(&passes);
        assert!(error.contains(expected) && error.contains("codec `toy`"), "{error}");
    };
    refused(&|p| p.passes.clear(), "there are none");
    refused(&|p| p.result = "c", "`c`, which is no scratch buffer");
    refused(&|p| p.scratch[1].words = 511, "`b` of 511 words, and a frame has 512 samples");
    refused(&|p| p.scratch[0].words = 0, "`a` has no words");
    refused(&|p| p.scratch[1].name = "a", "two scratch buffers are called `a`");
    refused(&|p| p.passes[0].scratch[0].buffer = "c", "uses `c`, which is no scratch buffer");
    refused(&|p| p.passes[0].scratch[1].buffer = "a", "has scratch buffer `a` under two names");
    refused(&|p| p.passes[0].scratch[0].name = "data", "are called `toy_data`");
    refused(&|p| p.passes[0].scratch[0].name = "set_to", "are called `toy_set_to`");
    refused(&|p| p.passes[0].scratch[0].name = "frame", "are called `toy_frame`");
    refused(&|p| p.passes[0].workgroups = [8, 0, 1], "dispatches 8×0×1 workgroups");
    refused(
        &|p| p.scratch[1].words = 7000,
        "needs 9 storage buffers, in parts of 4000 bytes; the device binds 8",
    );
    refused(
        &|p| p.scratch[0].words = (1 << 32) + 1,
        "has 4294967297 words; a shader's index reaches 4294967296",
    );
}
