//! Forms of shaders: only a short decoder is copied often.

use cvr::registry::{Names, renderer};
use cvr_core::codec::{Decoder, SettingValue, Site};
use cvr_core::render::{Filter, Light, Projection, Template};
use cvr_core::shader::{BindingLimits, Form, GeneratedShader, Module, Request, TextureSampling, generate};
use cvr_core::volume::SampleType;

use super::combinations::{source, view};
use super::copies::{copies, decoders, held};
use super::scene_combinations::Optics;
use super::volumes::{opened, varied};

fn decoder(codec: &str, settings: &[(&str, &str)]) -> Box<dyn Decoder> {
    let names = Names::new().unwrap();
    let codec = names.codecs().get(codec).unwrap();
    let settings =
        settings.iter().map(|(name, value)| ((*name).to_owned(), SettingValue::from(*value))).collect();
    opened(codec.as_ref(), &settings, &varied([9, 7, 5], SampleType::U8, 1))
}

/// The shader of a picture at the site *inline*. `change` modifies its pass first.
fn made(
    codec: &str,
    decoder: &dyn Decoder,
    (label, filter, lit): (&str, Filter, bool),
    change: impl Fn(&mut Vec<Module>),
) -> GeneratedShader {
    let optics = Optics { lit: lit.then_some(Light::Camera), ..Optics::default() };
    let view = optics.of(view(filter, Projection::Perspective), decoder);
    let mut plan = renderer(label).unwrap().plan(&view, decoder.layout()).unwrap();
    let [pass] = &mut plan.passes[..] else { panic!("several passes") };
    change(&mut pass.pipeline.offered);
    generate(&Request {
        program: &pass.pipeline.program(),
        layout: decoder.layout(),
        source: source(codec, decoder, Site::Inline, TextureSampling::Manual),
        filter: Some(filter),
        limits: BindingLimits::default(),
    })
    .unwrap()
}

const VARIABLE: &[(&str, &str)] = &[("payload", "variable"), ("rate", "0.5")];

#[test]
fn a_long_decoder_stands_once_and_a_short_one_wherever_it_is_asked() {
    use Filter::{Linear, Nearest, OptimisedLinear};
    use Form::{OneFetch, OneSample, Unrolled};
    type Case = (&'static str, &'static [(&'static str, &'static str)], Filter, bool, Form, u64);
    let cases: &[Case] = &[
        ("raw", &[], Nearest, false, Unrolled, 1),
        ("raw", &[], Linear, false, Unrolled, 8),
        ("raw", &[], Linear, true, Unrolled, 24),
        ("s3dc", &[], OptimisedLinear, true, Unrolled, 3),
        ("hvq", &[], Linear, true, Unrolled, 24),
        ("tvq", &[], Linear, true, Unrolled, 24),
        ("tvq", VARIABLE, Linear, false, Unrolled, 8),
        ("tvq", VARIABLE, Linear, true, OneSample, 8),
        ("tvq", VARIABLE, OptimisedLinear, true, OneSample, 1),
        ("zfp", &[], Nearest, false, Unrolled, 1),
        ("zfp", &[], Nearest, true, Unrolled, 3),
        ("zfp", &[], OptimisedLinear, false, Unrolled, 1),
        ("zfp", &[], OptimisedLinear, true, OneSample, 1),
        ("zfp", &[], Linear, false, OneFetch, 1),
        ("zfp", &[], Linear, true, OneFetch, 1),
    ];
    let mut wrong = Vec::new();
    for (codec, settings, filter, lit, form, copies) in cases {
        let decoder = decoder(codec, settings);
        for label in ["raycasting", "slicing"] {
            let shader = made(codec, decoder.as_ref(), (label, *filter, *lit), |_| ());
            let found = (shader.form, decoders(codec, &shader));
            let operations = shader.inlined_operations;
            println!("{codec} {settings:?} {label} {filter} {lit}: {found:?}, {operations} operations");
            if found != (*form, *copies) {
                wrong.push(format!("{codec} {settings:?} {label} {filter} {lit}: {found:?}, {operations}"));
            }
            held(codec, &shader).unwrap();
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The twin of the check over all combinations: an unknown module for neighbours, which the generator does not loop.
#[test]
fn a_long_decoder_that_stands_often_is_noticed() {
    let decoder = decoder("zfp", &[]);
    let unknown = |offered: &mut Vec<Module>| {
        let gradient = offered.iter_mut().find(|m| **m == cvr_shaders::GRADIENT.into()).unwrap();
        *gradient = Template { file: "shaders/optics/another.wgsl", ..cvr_shaders::GRADIENT }.into();
    };
    for label in ["raycasting", "slicing"] {
        let shader = made("zfp", decoder.as_ref(), (label, Filter::OptimisedLinear, true), unknown);
        assert_eq!(decoders("zfp", &shader), 3);
        held("zfp", &shader).unwrap_err();
    }
}

#[test]
fn copies_are_counted_over_all_ways_and_loops_once() {
    let text = "
        fn a() {}
        fn b() { a(); a(); }
        fn c(i: u32) { if i == 3u { b(); } else { a(); } switch i { case 1u: { b(); } default: {} } }
        @compute @workgroup_size(1) fn main() { for (var i = 0u; i < 9u; i++) { c(i); { b(); } } }
        @compute @workgroup_size(1) fn other() { a(); }";
    let of = |name| copies(text, "main", &[name]);
    assert_eq!([of("a"), of("b"), of("c"), of("d")], [7, 3, 1, 0]);
    assert_eq!(copies(text, "other", &["a"]), 1);
}
