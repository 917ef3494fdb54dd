//! Pictures of `cvr render`: at every site, voxels are compared with the CPU decoder first.

use std::sync::Arc;

use cvr::experiment::records::record::Record;
use cvr::experiment::running::single::{Single, SingleError};
use cvr::site::expected::Expected;
use cvr::site::target::Target;
use cvr_codec_tests::mutated::{Mutated, Mutation};
use cvr_core::codec::{Block, Decoder, Site};
use cvr_core::render::{Blending, DecodedFrame, Filter, Renderer};
use cvr_core::volume::{FrameIndex, Level, SampleType};
use cvr_engine::testing::test_device;
use cvr_raycasting::Raycasting;
use cvr_slicing::{Geometry, OpacityCorrection, Slicing};

use super::scenes::view;
use super::subjects::{ODD, codec, encoded, noise, settings};

const RING: Slicing = Slicing {
    geometry: Geometry::Axis,
    opacity_correction: OpacityCorrection::Exact,
    blending: Blending::Float32,
};

/// Whether there is a picture at a site, with or without a check, and the remarks.
fn draw(
    target: &Target,
    id: &str,
    decoder: &dyn Decoder,
    site: Site,
    check: bool,
) -> (Result<(), SingleError>, Record) {
    let frame = Arc::new(DecodedFrame::decode(decoder, FrameIndex::FIRST).unwrap());
    let block: Option<Block> = (id == "s3dc").then(|| "4".parse().unwrap());
    let expected = Expected { codec: id, decoder, key: (FrameIndex::FIRST, Level::FULL), frame, block };
    let renderer: &dyn Renderer = if site == Site::Ring { &RING } else { &Raycasting };
    let view = view(SampleType::U8, [24, 20], Filter::Linear);
    let mut record = Record::default();
    let single = Single { target, renderer, view: &view, site, expected: &expected, check };
    (single.draw(&mut record).map(drop), record)
}

fn s3dc() -> Box<dyn Decoder> {
    let settings = settings(&[("block", "4"), ("index_bits", "4")]);
    encoded(codec("s3dc").as_ref(), &settings, &noise(ODD, SampleType::U8))
}

#[test]
fn a_wrong_voxel_is_told_at_every_site_that_decodes_on_the_device() {
    let Some(device) = test_device("single::wrong_voxel") else { return };
    let target = Target::Device(device.clone());
    for site in [Site::Inline, Site::Deferred, Site::Ring] {
        let (right, record) = draw(&target, "s3dc", s3dc().as_ref(), site, true);
        assert!(right.is_ok() && record.parity_mismatches == Some(0), "{site:?}: {right:?}");
        assert!(!record.shader_not_run());
        let wrong = Mutated::snippet(s3dc(), "(1u << s3dc_index_bits) - 1u", "(1u << s3dc_index_bits) - 2u");
        let (told, record) = draw(&target, "s3dc", &wrong, site, true);
        let Err(SingleError::Disagrees(told)) = told else { panic!("{site:?}: {told:?}") };
        assert!(record.parity_mismatches.unwrap() > 100);
        for part in
            [" of 5083 samples disagree", "; the first is voxel ", ", in block ", " of 4×4×4 voxels: "]
        {
            assert!(told.contains(part), "{site:?}: {part} is not in {told}");
        }
        let (unchecked, record) = draw(&target, "s3dc", &wrong, site, false);
        assert!(unchecked.is_ok() && record.parity_mismatches.is_none(), "{site:?}");
    }
}

#[test]
fn a_wrong_block_of_a_texture_is_told_or_the_fallback_is() {
    let Some(device) = test_device("single::wrong_block") else { return };
    let target = Target::Device(device.clone());
    let bc4 = || encoded(codec("bc4").as_ref(), &settings(&[]), &noise(ODD, SampleType::U8));
    let (right, record) = draw(&target, "bc4", bc4().as_ref(), Site::Host, true);
    assert!(right.is_ok(), "{right:?}");
    let Some(mismatches) = record.parity_mismatches else {
        assert!(record.notes.unwrap().contains("blocks"), "why there is no texture of blocks is told");
        return;
    };
    assert_eq!(mismatches, 0);
    let wrong = Mutated { inner: bc4(), mutation: Mutation::Bit { resource: 0, word: 0, bit: 6 } };
    let (told, _) = draw(&target, "bc4", &wrong, Site::Host, true);
    assert!(matches!(told, Err(SingleError::Disagrees(_))), "{told:?}");
}

/// The mirror runs no shader, and says so.
#[test]
fn the_mirror_says_that_no_shader_ran() {
    let mirror = Target::Cpu { reason: None };
    for site in Site::ALL {
        let (drawn, record) = draw(&mirror, "s3dc", s3dc().as_ref(), site, true);
        assert!(drawn.is_ok() && record.parity_mismatches.is_none());
        assert_eq!(record.shader_not_run(), site != Site::Host, "{site:?}: {:?}", record.notes);
    }
}
