//! The site *deferred*: the texels that the device decodes, compared with the CPU's values and with pictures of the
//! other sites.

use cvr_codec_tests::mutated::Mutated;
use cvr_core::codec::{Agreement, Decoder, Parity, Site, TexelFormat};
use cvr_core::metrics::image_agreement;
use cvr_core::render::Filter;
use cvr_core::shader::BindingLimits;
use cvr_core::volume::{FrameIndex, Level, SampleType};
use cvr_engine::testing::test_device;
use cvr_engine::{Device, EngineError, VolumeTexture};

use super::scenes::{checked, draw, rule, source, textured, view};
use super::subjects::{ODD, codec, decoded, encoded, noise, settings};

const FIRST: FrameIndex = FrameIndex::FIRST;

/// Each texel format, and each kind of arithmetic.
const SUBJECTS: [(&str, &[(&str, &str)]); 5] = [
    ("raw", &[("bits", "native")]),
    ("raw", &[("bits", "8")]),
    ("raw", &[("bits", "half")]),
    ("s3dc", &[("block", "4"), ("index_bits", "4")]),
    ("s3dc", &[("block", "5x3x7"), ("index_bits", "8")]),
];

fn texture(device: &Device, codec: &str, decoder: &dyn Decoder) -> VolumeTexture {
    VolumeTexture::decode(device, codec, decoder, FIRST, Level::FULL).unwrap().0
}

fn parity(decoder: &dyn Decoder, texels: &[f32]) -> Parity {
    let agreement = decoder.shader().unwrap().agreement();
    Parity::compare(decoder, agreement, FIRST, &decoded(decoder), texels)
}

#[test]
fn every_texel_is_what_the_cpu_decodes() {
    let Some(device) = test_device("deferred::every_texel") else { return };
    for size in [ODD, [1, 1, 1], [5, 1, 130], [64, 2, 2]] {
        for sample in [SampleType::U8, SampleType::I8, SampleType::U16, SampleType::I16, SampleType::F32] {
            let volume = noise(size, sample);
            for (id, pairs) in SUBJECTS {
                let decoder = encoded(codec(id).as_ref(), &settings(pairs), &volume);
                let name = format!("{id} {pairs:?} {sample} {size:?}");
                let cpu = decoded(decoder.as_ref());
                let form = decoder.decoded_form();
                let host = VolumeTexture::upload(device, decoder.layout(), &cpu, form);
                let Ok(host) = host else {
                    // A single voxel in 8 bits has steps of size zero, which both refuse.
                    let (id, decoder) = (id, decoder.as_ref());
                    let refused = VolumeTexture::decode(device, id, decoder, FIRST, Level::FULL).unwrap_err();
                    assert_eq!((refused.to_string(), form.scale), (host.unwrap_err().to_string(), 0.0));
                    continue;
                };
                let got = texture(device, id, decoder.as_ref());
                assert_eq!((got.choice(), got.bytes()), (host.choice(), host.bytes()), "{name}");
                let (got, host) = (got.read(device).unwrap(), host.read(device).unwrap());
                let parity = parity(decoder.as_ref(), &got);
                assert!(parity.holds() && got.len() == cpu.len(), "{name}: {parity}");
                if parity.agreement == Agreement::Exact {
                    assert!(got == host && got == cpu, "{name}: exact, but not bit for bit");
                }
                // Steps must be whole numbers, so that the last digits of a value do not choose between two steps.
                if form.format == TexelFormat::Unorm8 {
                    assert!(got == host, "{name}");
                }
            }
        }
    }
}

#[test]
fn slabs_and_split_buffers_do_not_show() {
    let Some(device) = test_device("deferred::slabs") else { return };
    // Rows have 64 words, slices 1088: two slices at a time, one, and seven rows. The codecs' buffers are split too;
    // raw's samples have 2542 words.
    for (id, pairs, storage_words) in [
        ("raw", SUBJECTS[0].1, 2500),
        ("raw", SUBJECTS[0].1, 1100),
        ("s3dc", SUBJECTS[3].1, 450),
        ("s3dc", SUBJECTS[4].1, 640),
    ] {
        let decoder = encoded(codec(id).as_ref(), &settings(pairs), &noise(ODD, SampleType::U16));
        let small = device.with_binding_limits(BindingLimits { storage_words, storage_buffers: 8 });
        let whole = texture(device, id, decoder.as_ref()).read(device).unwrap();
        let slabs = texture(&small, id, decoder.as_ref()).read(device).unwrap();
        assert!(whole == slabs, "{id} in slabs of {storage_words} words");
    }
}

#[test]
fn pictures_are_those_of_host_and_under_nearest_those_of_inline() {
    let Some(device) = test_device("deferred::pictures") else { return };
    for (id, pairs) in SUBJECTS {
        for sample in [SampleType::U8, SampleType::F32] {
            let volume = textured(ODD, [1.0, 1.5, 0.7], sample);
            let decoder = encoded(codec(id).as_ref(), &settings(pairs), &volume);
            // A device may be off by an ulp when it converts a unorm texel to a number, and a shader may differ from
            // the CPU.
            let form = decoder.decoded_form().format;
            let floats = matches!(form, TexelFormat::Float16 | TexelFormat::Float32);
            let exact = parity(decoder.as_ref(), &decoded(decoder.as_ref())).agreement == Agreement::Exact;
            let tolerance = |equal: bool| if equal { 0.0 } else { 1e-5 };
            for filter in [Filter::Nearest, Filter::Linear] {
                let view = view(sample, [80, 64], filter);
                let [inline, deferred, host] = [Site::Inline, Site::Deferred, Site::Host]
                    .map(|site| draw(device, &view, &source(device, site, id, decoder.as_ref())));
                let name = format!("{id} {pairs:?} {sample} {filter}");
                assert!(deferred.0.pixels().iter().filter(|p| p[3] > 0.1).count() > 500, "{name}");
                assert_eq!(deferred.1, host.1, "{name}: filtered by others");
                let difference = image_agreement(&deferred.0, &host.0, 0.0).unwrap().max_difference;
                assert!(difference <= tolerance(exact || !floats), "{name}, host: {difference}");
                if filter == Filter::Nearest {
                    let difference = image_agreement(&deferred.0, &inline.0, 0.0).unwrap().max_difference;
                    assert!(difference <= tolerance(floats), "{name}, inline: {difference}");
                } else {
                    let choice =
                        device.capabilities().texture(decoder.decoded_form(), decoder.layout().extent);
                    assert_eq!(deferred.1, choice.unwrap().sampling, "{name}");
                    rule(deferred.1).check(&inline.0, &deferred.0).unwrap();
                }
            }
        }
    }
}

#[test]
fn what_stays_resident_is_the_texture_and_the_stream() {
    let Some(device) = test_device("deferred::resident") else { return };
    let decoder = encoded(codec("s3dc").as_ref(), &settings(SUBJECTS[3].1), &noise(ODD, SampleType::U8));
    let texture = texture(device, "s3dc", decoder.as_ref());
    let words: usize =
        decoder.shader().unwrap().resources(FIRST).unwrap().iter().map(|r| r.words.len()).sum();
    let texels = 13 * 17 * 23 * 4;
    assert_eq!((texture.bytes(), texture.resident_bytes()), (texels, texels + 4 * words as u64));
}

/// The failing twin: an off-by-one in the snippet reaches the texture. This comparison and a run's own detect it.
#[test]
fn a_wrong_snippet_is_caught() {
    let Some(device) = test_device("deferred::wrong_snippet") else { return };
    for (id, pairs, from, to) in [
        ("raw", SUBJECTS[0].1, "lane * raw_bits", "(lane + 1u) * raw_bits"),
        ("s3dc", SUBJECTS[3].1, "(1u << s3dc_index_bits) - 1u", "(1u << s3dc_index_bits) - 2u"),
    ] {
        let volume = noise(ODD, SampleType::U8);
        let mutated = Mutated::snippet(encoded(codec(id).as_ref(), &settings(pairs), &volume), from, to);
        let texels = texture(device, id, &mutated).read(device).unwrap();
        assert!(!parity(&mutated, &texels).holds(), "{id}: `{to}` goes unnoticed");
        let told = checked(device, Site::Deferred, id, &mutated);
        let problem = told.problem.unwrap();
        assert!(
            told.mismatches > 0 && problem.starts_with("what the device decoded is not what"),
            "{problem}"
        );
    }
    // One texel off by one.
    let decoder = encoded(codec("raw").as_ref(), &settings(SUBJECTS[0].1), &noise(ODD, SampleType::U8));
    let mut texels = texture(device, "raw", decoder.as_ref()).read(device).unwrap();
    assert!(parity(decoder.as_ref(), &texels).holds());
    texels[1234] += 1.0;
    assert_eq!(parity(decoder.as_ref(), &texels).mismatches, 1);
}

#[test]
fn what_does_not_fit_is_refused_with_both_numbers() {
    let Some(device) = test_device("deferred::too_large") else { return };
    let limit = device.capabilities().texture_edge_voxels;
    let long = noise([limit + 1, 1, 1], SampleType::U8);
    let decoder = encoded(codec("raw").as_ref(), &settings(&[]), &long);
    let decode = |device: &Device| {
        VolumeTexture::decode(device, "raw", decoder.as_ref(), FIRST, Level::FULL).unwrap_err()
    };
    let error = decode(device);
    assert!(matches!(error, EngineError::TooLarge { .. }), "{error}");
    assert!(error.to_string().contains(&format!("offers {limit}")), "{error}");
}
