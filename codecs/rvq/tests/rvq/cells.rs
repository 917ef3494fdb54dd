//! The cell equals eight fetches, for every form of entries and width of codes.

use std::sync::Arc;

use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, encode_temporary};
use cvr_core::conformance::{cells_are_eight_fetches, noise};
use cvr_core::kit::FetchVoxels as _;
use cvr_core::volume::{Extent, FrameIndex};
use cvr_rvq::Rvq;
use cvr_rvq::decode::Frame;
use cvr_rvq::stream::{Geometry, Parameters};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn a_cell_is_eight_fetches(
        size in [1_u32..20, 1_u32..9, 1_u32..9],
        stages in 1_u32..6,
        codewords in 2_u32..40,
        entries in prop_oneof![Just("8"), Just("16"), Just("auto")],
        resolution in 0_usize..3,
        shown in 1_usize..7,
        variable: bool,
        rgb: bool,
        seed: u32,
    ) {
        let volume = noise(size, if rgb { 3 } else { 1 }, seed);
        let [stages_text, size_text] = [stages, codewords].map(|n| n.to_string());
        let settings = settings(&[
            ("payload", if variable { "variable" } else { "fixed" }),
            ("rate", if variable { "4" } else { "0" }),
            ("stages", &stages_text),
            ("codewords", &size_text),
            ("entries", entries),
            ("iterations", "1"),
            ("refinement", "0"),
            ("beam", "1"),
        ]);
        let stream = Arc::new(encode_temporary(&Rvq, &settings, &volume).unwrap());
        let parameters: Parameters = stream.parameters().unwrap();
        let decoder = Rvq.decoder(stream).unwrap();
        let resources = decoder.shader().unwrap().resources(FrameIndex::FIRST).unwrap();
        let geometry = Geometry::new(decoder.layout(), &parameters).unwrap();
        let units = geometry.units(0);
        let words = |name: &str| resources.iter().find(|r| r.name == name).map_or(&[][..], |r| &r.words[..]);
        let frame = Frame {
            index: words("index"),
            heads: words("heads"),
            mean_shift: geometry.tables[0].mean_shift,
            codebook: words("codebook"),
            units: &units,
            resolution,
            stages: shown.min(geometry.stages as usize),
            geometry: &geometry,
        };
        let extent: Extent = decoder.layout().extent.at_resolution(resolution as u8);
        let same = cells_are_eight_fetches(extent, |p| frame.fetch(p), |p, q| frame.fetch_cell(p, q));
        prop_assert!(same.is_ok(), "{same:?}");
    }
}
