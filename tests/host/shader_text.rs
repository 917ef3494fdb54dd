//! The generated text itself: it holds no more than the scene uses.

use cvr::registry::{Names, renderer, renderers};
use cvr_core::codec::{SettingValue, Settings, Site};
use cvr_core::render::{Filter, Light, Projection};
use cvr_core::shader::TextureSampling;
use cvr_core::volume::SampleType;

use super::combinations::{shader, source, view};
use super::copies::calls_of;
use super::scene_combinations::{Optics, labels};
use super::volumes::{opened, varied};

#[derive(Copy, Clone)]
struct Scene {
    renderer: &'static str,
    codec: &'static str,
    site: Site,
    sampling: TextureSampling,
    filter: Filter,
    projection: Projection,
    optics: Optics,
}

/// The paper's nearest access, in perspective.
const S3DC: Scene = Scene {
    renderer: "raycasting",
    codec: "s3dc",
    site: Site::Inline,
    sampling: TextureSampling::Manual,
    filter: Filter::Nearest,
    projection: Projection::Perspective,
    optics: UNLIT,
};

/// Unlit and whole; nothing is skipped.
const UNLIT: Optics = Optics { lit: None, clipped: false, skipping: false };

fn text(scene: &Scene) -> String {
    text_by(scene.renderer, scene)
}

/// The same with the renderer of another label.
fn text_by(label: &str, scene: &Scene) -> String {
    let names = Names::new().unwrap();
    let codec = names.codecs().get(scene.codec).unwrap();
    let settings: Settings = match scene.codec {
        "s3dc" => [("block", SettingValue::Integer(4)), ("index_bits", SettingValue::Integer(2))]
            .map(|(name, value)| (name.to_owned(), value))
            .into_iter()
            .collect(),
        _ => Settings::default(),
    };
    let settings = codec.info().complete(&settings).unwrap();
    let decoder = opened(codec.as_ref(), &settings, &varied([13, 17, 23], SampleType::U8, 1));
    let source = source(scene.codec, decoder.as_ref(), scene.site, scene.sampling);
    let view = scene.optics.of(view(scene.filter, scene.projection), decoder.as_ref());
    shader(renderer(label).unwrap().as_ref(), &view, decoder.as_ref(), &source).unwrap().wgsl.clone()
}

/// The origins of the parts, in their order.
fn parts(text: &str) -> Vec<&str> {
    text.lines().filter_map(|line| line.strip_prefix("// ==== ")).collect()
}

/// Functions that nothing calls, directly or through others, from the entry point.
fn unused(text: &str) -> Vec<String> {
    let module = naga::front::wgsl::parse_str(text).unwrap();
    let calls = |function: &naga::Function| {
        let mut callees = Vec::new();
        calls_of(&function.body, &mut callees);
        callees
    };
    let mut used = std::collections::HashSet::new();
    let mut open: Vec<_> = module.entry_points.iter().flat_map(|e| calls(&e.function)).collect();
    while let Some(callee) = open.pop() {
        if used.insert(callee) {
            open.extend(calls(&module.functions[callee]));
        }
    }
    let rest = module.functions.iter().filter(|(handle, _)| !used.contains(handle));
    rest.filter_map(|(_, function)| function.name.clone()).collect()
}

#[test]
fn a_projection_leaves_the_other_out() {
    let perspective = text(&S3DC);
    let orthographic = text(&Scene { projection: Projection::Orthographic, ..S3DC });
    for (text, has, lacks) in
        [(&perspective, "perspective", "orthographic"), (&orthographic, "orthographic", "perspective")]
    {
        let parts = parts(text);
        assert!(parts.contains(&&*format!("shaders/camera/{has}.wgsl")), "{parts:?}");
        assert!(!text.contains(lacks));
        assert_eq!(text.matches("fn camera_ray(").count(), 1);
    }
}

#[test]
fn a_filter_leaves_the_others_out() {
    let nearest = text(&S3DC);
    assert!(nearest.contains("fn voxel_fetch(") && !nearest.contains("trilinear"));
    let linear = text(&Scene { filter: Filter::Linear, ..S3DC });
    assert!(linear.contains("fn trilinear(") && !linear.contains("voxel_cell"));
    let optimised = text(&Scene { filter: Filter::OptimisedLinear, ..S3DC });
    assert!(optimised.contains("fn trilinear(") && optimised.contains("fn voxel_cell("));
    for text in [nearest, linear, optimised] {
        assert_eq!(text.matches("fn volume_sample(").count(), 1);
        assert!(!text.contains("volume_texture"), "nothing is decoded beforehand");
    }
}

#[test]
fn a_decoded_texture_leaves_the_codec_out() {
    let host =
        Scene { site: Site::Host, filter: Filter::Linear, sampling: TextureSampling::Hardware, ..S3DC };
    let hardware = text(&host);
    assert!(hardware.contains("textureSampleLevel(") && !hardware.contains("voxel_fetch"));
    assert!(!hardware.contains("trilinear"));
    let manual = text(&Scene { sampling: TextureSampling::Manual, ..host });
    assert!(manual.contains("fn trilinear(") && manual.contains("textureLoad(volume_texture"));
    assert!(!manual.contains("sampler"));
    for text in [hardware, manual] {
        assert!(!text.contains("s3dc") && !text.contains("array<u32>"));
    }
}

#[test]
fn no_codec_names_another() {
    assert!(!text(&S3DC).contains("raw_"));
    assert!(!text(&Scene { codec: "raw", ..S3DC }).contains("s3dc_"));
}

#[test]
fn a_scene_leaves_out_what_it_does_not_use() {
    for label in renderers().iter().flat_map(|r| labels(r.info())) {
        for optics in Optics::all() {
            let text = text_by(&label, &Scene { optics, ..S3DC });
            let lower = text.to_lowercase();
            for (used, words) in [
                (optics.lit.is_some(), &["gradient", "lighting", "blinn_phong", "shininess"][..]),
                (optics.clipped, &["clip"]),
                (optics.skipping, &["macrocell"]),
            ] {
                for word in words {
                    assert_eq!(lower.contains(word), used, "{label}, {optics:?}: {word}");
                }
            }
            let choices = [("optical(", 1), ("bounds_low(", 1), ("bounds_high(", 1), ("may_show(", 1)];
            for (function, most) in choices {
                assert!(
                    text.matches(&format!("fn {function}")).count() <= most,
                    "{label}, {optics:?}: {function}"
                );
            }
        }
    }
}

#[test]
fn a_stack_of_slices_knows_one_geometry_and_one_opacity() {
    let slicing = renderer("slicing").unwrap();
    let mut texts = Vec::new();
    for label in labels(slicing.info()) {
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let text = text_by(&label, &Scene { projection, ..S3DC });
            for function in ["fn slab_crossing(", "fn slice_opacity(", "fn shown(", "fn proxy("] {
                assert_eq!(text.matches(function).count(), 1, "{label}, {projection:?}: {function}");
            }
            let spheres = label.contains("shells") && projection == Projection::Perspective;
            assert_eq!(text.contains("shells.wgsl"), spheres, "{label}, {projection:?}");
            assert_eq!(text.contains("opacity_lerp.wgsl"), label.contains("lerp"), "{label}");
            assert!(!text.contains("next_sample") && !text.contains("@compute"), "{label}");
            texts.push(text);
        }
    }
    texts.sort();
    texts.dedup();
    assert_eq!(
        texts.len(),
        6,
        "planes or spheres of one eye, planes of parallel rays; each exact or interpolated"
    );
}

/// Every function of generator and templates is called. A codec's snippet is copied unchanged.
#[test]
fn templates_bring_no_function_that_nothing_calls() {
    let idle = |label: &str, scene: &Scene| {
        let text = text_by(label, scene);
        let unused: Vec<String> = unused(&text).into_iter().filter(|n| !n.starts_with("s3dc_")).collect();
        let Scene { filter, projection, optics, .. } = scene;
        assert!(unused.is_empty(), "{label}, {filter}, {projection:?}, {optics:?}: {unused:?}");
    };
    for label in renderers().iter().flat_map(|r| labels(r.info())) {
        for projection in [Projection::Perspective, Projection::Orthographic] {
            for filter in Filter::ALL {
                idle(&label, &Scene { filter, projection, ..S3DC });
            }
            for optics in Optics::all() {
                idle(&label, &Scene { optics, projection, ..S3DC });
            }
            let layers = renderers().iter().any(|r| r.info().draws_layers(&label));
            for (sampling, filter) in [
                (TextureSampling::Hardware, Filter::Linear),
                (TextureSampling::Manual, Filter::Linear),
                (TextureSampling::Hardware, Filter::Nearest),
            ] {
                if layers {
                    idle(&label, &Scene { site: Site::Ring, sampling, filter, projection, ..S3DC });
                }
            }
        }
    }
}

/// A picture without rays in pieces has no code for them in its shader.
#[test]
fn rays_at_once_know_no_pieces() {
    let text = text(&S3DC);
    assert!(parts(&text).contains(&"shaders/rays/at_once.wgsl"));
    for word in ["progress", "pieces", "in_pieces.wgsl"] {
        assert!(!text.contains(word), "{word}");
    }
}

#[test]
fn a_function_that_nothing_calls_is_noticed() {
    let text = text(&S3DC);
    let with_more = format!("{text}\nfn idle(x: f32) -> f32 {{\n    return x;\n}}\n");
    assert!(unused(&with_more).contains(&"idle".to_owned()));
    assert!(!unused(&text).contains(&"follow_ray".to_owned()));
}

#[test]
fn a_whole_shader_is_what_it_should_be() {
    insta::assert_snapshot!(text(&Scene { filter: Filter::Linear, ..S3DC }));
}

#[test]
fn a_whole_shader_of_a_lit_and_clipped_scene() {
    let optics = Optics { lit: Some(Light::Camera), clipped: true, skipping: false };
    let raw = Scene { codec: "raw", filter: Filter::Linear, optics, ..S3DC };
    insta::assert_snapshot!(text(&raw));
}

#[test]
fn a_whole_shader_of_slices_from_a_ring() {
    let ring = Scene {
        renderer: "slicing,geometry=axis",
        site: Site::Ring,
        sampling: TextureSampling::Hardware,
        filter: Filter::Linear,
        projection: Projection::Orthographic,
        ..S3DC
    };
    insta::assert_snapshot!(text(&ring));
}

#[test]
fn a_whole_shader_of_slices() {
    let texture = Scene {
        renderer: "slicing,geometry=shells,opacity_correction=lerp",
        site: Site::Host,
        sampling: TextureSampling::Hardware,
        filter: Filter::Linear,
        optics: Optics { skipping: true, ..UNLIT },
        ..S3DC
    };
    insta::assert_snapshot!(text(&texture));
}
