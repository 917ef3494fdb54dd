//! Pictures of the device compared with each other: which must be equal, and how far others may differ.

use cvr_core::codec::{Agreement, Site, TexelFormat};
use cvr_core::metrics::{AgreementRule, image_agreement};
use cvr_core::render::{Filter, Image, View};
use cvr_core::volume::SampleType;
use cvr_engine::testing::test_device;

use super::scenes::{draw, source, textured, view};
use super::subjects::{ODD, codec, encoded, settings};

const SIZE: [u32; 2] = [80, 64];

fn largest_difference(a: &Image, b: &Image) -> f32 {
    image_agreement(a, b, 0.0).unwrap().max_difference
}

fn visible(image: &Image) -> bool {
    image.pixels().iter().filter(|p| p[3] > 0.1).count() > 500
}

#[test]
fn nearest_is_the_same_picture_inline_and_host() {
    let Some(device) = test_device("picture_relations::nearest") else { return };
    for (id, pairs, sample) in [
        ("raw", &[][..], SampleType::U8),
        ("raw", &[("bits", "half")], SampleType::F32),
        ("raw", &[], SampleType::I16),
        ("s3dc", &[("block", "4")], SampleType::F32),
    ] {
        let volume = textured(ODD, [1.0, 1.5, 0.7], sample);
        let decoder = encoded(codec(id).as_ref(), &settings(pairs), &volume);
        let view = view(sample, SIZE, Filter::Nearest);
        let [inline, host] = [Site::Inline, Site::Host]
            .map(|site| draw(device, &view, &source(device, site, id, decoder.as_ref())).0);
        assert!(visible(&inline));
        // A device may be off by an ulp when it converts a unorm texel to a number, plus the codec's stated agreement.
        // Floats are returned unchanged.
        let floats = matches!(decoder.decoded_form().format, TexelFormat::Float16 | TexelFormat::Float32);
        let exact = floats && decoder.shader().unwrap().agreement() == Agreement::Exact;
        let tolerance = if exact { 0.0 } else { 1e-5 };
        let difference = largest_difference(&inline, &host);
        assert!(difference <= tolerance, "{id} {pairs:?} {sample}: {difference}");
    }
}

#[test]
fn optimised_linear_is_linear() {
    let Some(device) = test_device("picture_relations::optimised_linear") else { return };
    for (block, sample) in [("4", SampleType::U8), ("5x3x7", SampleType::F32)] {
        let volume = textured(ODD, [1.0; 3], sample);
        let decoder = encoded(codec("s3dc").as_ref(), &settings(&[("block", block)]), &volume);
        let source = source(device, Site::Inline, "s3dc", decoder.as_ref());
        let [nearest, linear, optimised] = [Filter::Nearest, Filter::Linear, Filter::OptimisedLinear]
            .map(|filter| draw(device, &view(sample, SIZE, filter), &source).0);
        assert!(visible(&linear));
        AgreementRule::MANUAL.check(&linear, &optimised).unwrap();
        // The rule distinguishes filters.
        assert!(AgreementRule::MANUAL.check(&linear, &nearest).is_err());
    }
}

#[test]
fn early_termination_costs_no_more_than_it_says() {
    let Some(device) = test_device("picture_relations::termination") else { return };
    let decoder =
        encoded(codec("raw").as_ref(), &settings(&[]), &textured([32; 3], [1.0; 3], SampleType::U8));
    let source = source(device, Site::Inline, "raw", decoder.as_ref());
    let with = |termination| {
        draw(device, &View { termination, ..view(SampleType::U8, SIZE, Filter::Linear) }, &source).0
    };
    let whole = with(1.0);
    for termination in [0.5, 0.9, 0.99] {
        let difference = largest_difference(&whole, &with(termination));
        assert!(difference > 0.0, "until {termination}: no ray ended early");
        assert!(difference <= 1.0 - termination + 1e-6, "until {termination}: {difference}");
    }
}
