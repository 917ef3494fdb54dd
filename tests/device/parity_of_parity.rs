//! Tests of the parity test: it detects an off-by-one in a snippet and a single wrong bit in a buffer.

use std::sync::Arc;

use cvr::experiment::records::record::Record;
use cvr::experiment::running::encoded::{Encoded, encode};
use cvr::experiment::running::shared::Shared;
use cvr::site::target::Target;
use cvr_codec_tests::mutated::{Mutated, Mutation};
use cvr_core::codec::{Decoder, Parity, Progress, ShaderDecode as _, Site, VoxelDump};
use cvr_core::pipeline::FrameRange;
use cvr_core::volume::{FrameIndex, SampleType};
use cvr_engine::Device;
use cvr_engine::testing::test_device;

use super::subjects::{ODD, codec, decoded, encoded, noise, settings};

const SETTINGS: &[(&str, &[(&str, &str)])] =
    &[("raw", &[("bits", "native")]), ("s3dc", &[("block", "4"), ("index_bits", "4")])];

fn decoder(id: &str) -> Box<dyn Decoder> {
    let (_, pairs) = SETTINGS.iter().find(|(codec, _)| *codec == id).unwrap();
    encoded(codec(id).as_ref(), &settings(pairs), &noise(ODD, SampleType::U8))
}

fn parity(device: &Device, id: &str, mutated: &Mutated, use_cell: bool) -> Parity {
    let dump = device.dump(id, mutated, FrameIndex::FIRST, use_cell).unwrap();
    Parity::compare(mutated, mutated.agreement(), FrameIndex::FIRST, &decoded(mutated), &dump)
}

#[test]
fn an_off_by_one_in_a_snippet_is_caught() {
    let Some(device) = test_device("parity_of_parity::off_by_one") else { return };
    for (id, from, to, use_cell) in [
        ("raw", "raw_samples(i >> raw_lanes_log2)", "raw_samples((i >> raw_lanes_log2) + 1u)", false),
        ("raw", "lane * raw_bits", "(lane + 1u) * raw_bits", false),
        ("s3dc", "v / s3dc_block)", "(v + 1u) / s3dc_block)", false),
        ("s3dc", "(1u << s3dc_index_bits) - 1u", "(1u << s3dc_index_bits) - 2u", false),
        ("s3dc", "f32(index) * s3dc_reciprocal", "f32(index + 1u) * s3dc_reciprocal", true),
        ("s3dc", "w / s3dc_block", "v / s3dc_block", true),
        ("s3dc", "out[6][c] = pair_11.x", "out[6][c] = pair_10.x", true),
    ] {
        let mutated = Mutated::snippet(decoder(id), from, to);
        let parity = parity(device, id, &mutated, use_cell);
        assert!(!parity.holds(), "{id}: `{to}` goes unnoticed");
    }
}

#[test]
fn one_bit_of_a_buffer_is_caught() {
    let Some(device) = test_device("parity_of_parity::one_bit") else { return };
    for (id, resources) in [("raw", 1), ("s3dc", 2)] {
        for resource in 0..resources {
            let mutation = Mutation::Bit { resource, word: 7, bit: 16 };
            let mutated = Mutated { inner: decoder(id), mutation };
            let parity = parity(device, id, &mutated, false);
            assert!(!parity.holds(), "{id}, resource {resource}: a flipped bit goes unnoticed");
            // A bit of a sample or of an index changes one voxel. A bit of an endpoint changes at most one block.
            let most = if id == "s3dc" && resource == 0 { 64 } else { 1 };
            assert!(parity.mismatches <= most, "{id}, resource {resource}: {parity}");
        }
    }
}

#[test]
fn an_unchanged_shader_passes_the_same_comparison() {
    let Some(device) = test_device("parity_of_parity::unchanged") else { return };
    for (id, _) in SETTINGS {
        let inner = decoder(id);
        let source = inner.shader().unwrap().module().source.to_owned();
        let parity = parity(device, id, &Mutated { inner, mutation: Mutation::Snippet(source) }, false);
        assert!(parity.holds(), "{id}: {parity}");
    }
}

/// The same in a run: the cell's record names the first voxel that differs.
#[test]
fn a_cell_at_inline_tells_the_first_voxel_that_differs() {
    let Some(device) = test_device("parity_of_parity::cell_at_inline") else { return };
    let (folder, volume) = (tempfile::tempdir().unwrap(), noise(ODD, SampleType::U8));
    let raw = codec("raw");
    let settings = raw.info().default_settings();
    let mut stream =
        encode(raw.as_ref(), &settings, &volume, (folder.path(), 64), &Progress::silent()).unwrap();
    let target = Target::Device(device.clone());
    let told = |stream: &Encoded| {
        let shared = Shared::new(&target, "raw", stream, std::iter::empty());
        let mut record = Record::default();
        shared.prepared(Site::Inline, FrameIndex::FIRST, &mut record).unwrap();
        (shared.problem(Site::Inline, FrameRange::default()), record.parity_mismatches)
    };
    assert_eq!(told(&stream), (None, Some(0)));
    let same = encoded(raw.as_ref(), &settings, &volume);
    stream.decoder = Arc::new(Mutated::snippet(same, "lane * raw_bits", "(lane ^ 1u) * raw_bits"));
    let (problem, mismatches) = told(&stream);
    let problem = problem.unwrap();
    let begins = "what the shader fetches is not what the CPU decodes: ";
    assert!(
        problem.starts_with(begins) && problem.contains("the first is voxel 0 0 0 (frame 0): "),
        "{problem}"
    );
    assert!(mismatches.unwrap() > 1000);
}
