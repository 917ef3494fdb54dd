//! Errors for what a device cannot do. The device still works afterwards.

use cvr_codec_tests::mutated::{Mutated, Mutation};
use cvr_core::codec::{DecodedForm, Decoder};
use cvr_core::render::{Contents, Filter, Pass, Plan, Renderer, View};
use cvr_core::shader::{Module, Variable};
use cvr_core::volume::{Extent, SampleType, VolumeLayout};
use cvr_engine::testing::test_device;
use cvr_engine::{Device, DrawSource, Drawing, EngineError, VolumeTexture};
use cvr_raycasting::Raycasting;

use super::scenes::{inline, textured, view};
use super::subjects::{ODD, codec, encoded, settings};

const SAMPLE: SampleType = SampleType::U8;

fn raw() -> Box<dyn Decoder> {
    encoded(codec("raw").as_ref(), &settings(&[]), &textured(ODD, [1.0; 3], SAMPLE))
}

fn plan(size: [u32; 2], decoder: &dyn Decoder) -> Plan {
    Raycasting.plan(&view(SAMPLE, size, Filter::Linear), decoder.layout()).unwrap()
}

fn refused(device: &Device, size: [u32; 2], source: &DrawSource<'_>, decoder: &dyn Decoder) -> EngineError {
    Drawing::new(device, &plan(size, decoder), source, Filter::Linear).unwrap_err()
}

#[test]
fn a_texture_beyond_the_device_is_refused_with_both_numbers() {
    let Some(device) = test_device("refusal::texture") else { return };
    let limit = device.capabilities().texture_edge_voxels;
    for axis in 0..3 {
        let mut size = [1; 3];
        size[axis] = limit + 1;
        let layout = VolumeLayout::scalar(Extent::try_from(size).unwrap(), SAMPLE);
        let values = vec![0.0; limit as usize + 1];
        let error = VolumeTexture::upload(device, &layout, &values, DecodedForm::FLOAT32).unwrap_err();
        let text = error.to_string();
        assert!(matches!(error, EngineError::TooLarge { .. }), "{text}");
        assert!(text.contains(&(limit + 1).to_string()), "{text}");
        assert!(text.contains(&format!("offers {limit}")), "{text}");
        // One voxel less works.
        size[axis] = limit;
        let layout = VolumeLayout::scalar(Extent::try_from(size).unwrap(), SAMPLE);
        VolumeTexture::upload(device, &layout, &values[1..], DecodedForm::FLOAT32).unwrap();
    }
}

#[test]
fn a_broken_snippet_is_shown_at_its_own_place() {
    let Some(device) = test_device("refusal::snippet") else { return };
    let source = raw().shader().unwrap().module().source.to_owned();
    // The replaced text, its replacement, and the error. Line and column refer to codecs/raw/src/decode.wgsl.
    for (from, to, at, said) in [
        ("return f32(code);", "return vec2<f32>(1.0, 2.0);", "vec2", "raw_value"),
        ("return raw_half(code);", "return raw_halve(code);", "raw_halve", "raw_halve"),
        ("out[c] = raw_value(", "out[c] = (raw_value(", ";\n    }\n    return out;", "expected"),
    ] {
        assert!(source.contains(from), "the snippet has changed: it holds no `{from}`");
        let broken = source.replace(from, to);
        let change = broken.find(to).unwrap();
        let place = change + broken[change..].find(at).unwrap();
        let line = broken[..place].matches('\n').count() + 1;
        let mutated = Mutated { inner: raw(), mutation: Mutation::Snippet(broken.clone()) };
        let error = refused(device, [16, 16], &inline("raw", &mutated), &mutated);
        let text = error.to_string();
        assert!(matches!(error, EngineError::Shader(_)), "{text}");
        assert!(text.contains(said), "{text}");
        let found = text.split("codecs/raw/src/decode.wgsl:").nth(1).expect(&text);
        let mut numbers = found.split(|c: char| !c.is_ascii_digit()).map(|n| n.parse::<usize>().unwrap_or(0));
        let (found_line, found_column) = (numbers.next().unwrap(), numbers.next().unwrap());
        assert_eq!(found_line, line, "{to}: {text}");
        let width = broken.lines().nth(line - 1).unwrap().chars().count();
        assert!((1..=width + 1).contains(&found_column), "{to}: {text}");
        // The author sees the line itself.
        assert!(text.contains(broken.lines().nth(line - 1).unwrap().trim()), "{text}");
    }
}

#[test]
fn pictures_out_of_range_are_errors() {
    let Some(device) = test_device("refusal::picture_size") else { return };
    let raw = raw();
    let source = inline("raw", raw.as_ref());
    for size in [[0, 16], [16, 0], [0, 0]] {
        let error = refused(device, size, &source, raw.as_ref());
        let text = error.to_string();
        assert!(matches!(error, EngineError::Unsupported(_)), "{text}");
        assert!(text.contains(&format!("{}×{}", size[0], size[1])), "{text}");
    }
    for size in [[1 << 20, 1 << 20], [u32::MAX, 1], [u32::MAX, u32::MAX]] {
        let error = refused(device, size, &source, raw.as_ref());
        assert!(matches!(error, EngineError::TooLarge { .. }), "{size:?}: {error}");
    }
}

/// After each refusal the very same device draws the very same picture.
#[test]
fn a_refusal_does_not_poison_the_next_drawing() {
    let Some(device) = test_device("refusal::no_poison") else { return };
    let raw = raw();
    let source = inline("raw", raw.as_ref());
    let good = || {
        let View { size, .. } = view(SAMPLE, [32, 24], Filter::Linear);
        let drawing = Drawing::new(device, &plan(size, raw.as_ref()), &source, Filter::Linear).unwrap();
        drawing.draw_timed().unwrap();
        drawing.read_image().unwrap()
    };
    let before = good();
    assert!(before.pixels().iter().any(|p| p[3] > 0.1));

    refused(device, [0, 0], &source, raw.as_ref());
    assert!(good() == before, "after a picture of no size");
    let mutated = Mutated { inner: self::raw(), mutation: Mutation::Snippet("fn raw_fetch(".to_owned()) };
    refused(device, [16, 16], &inline("raw", &mutated), &mutated);
    assert!(good() == before, "after a broken snippet");
    // A uniform shorter than the struct that the shader reads.
    let mut short = plan([16, 16], raw.as_ref());
    short.passes[0].inputs.contents[0].bytes.truncate(16);
    let error = Drawing::new(device, &short, &source, Filter::Linear).unwrap_err();
    assert!(
        matches!(&error, EngineError::Unsupported(text) if text.contains("`view` has 16 bytes")),
        "{error}"
    );
    assert!(good() == before, "after a short uniform");
    // The driver's own validation: a buffer shorter than its shader expects.
    let mut short = plan([16, 16], raw.as_ref());
    let Pass { pipeline, inputs } = &mut short.passes[0];
    let gather = pipeline.modules.pop().unwrap();
    let source_text = gather.source().replace("let sample = ", "let sample = tints[99] + ");
    pipeline.modules.push(Module::Generated { purpose: "a tint", source: source_text });
    pipeline.variables.push(Variable::read("tints", "array<vec4<f32>, 100>"));
    inputs.contents.push(Contents { name: "tints", bytes: vec![0; 16] });
    let error =
        Drawing::new(device, &short, &source, Filter::Linear).and_then(|d| d.draw_timed()).unwrap_err();
    assert!(matches!(error, EngineError::Gpu(_)), "{error}");
    assert!(good() == before, "after a validation error");
}
