//! The cell function equals eight fetches, for every index width, number of stages and block position.

use std::sync::Arc;

use cvr_core::codec::{Codec as _, SettingValue, Settings, encode_temporary};
use cvr_core::conformance::{cells_are_eight_fetches, noise};
use cvr_core::kit::FetchVoxels as _;
use cvr_core::volume::FrameIndex;
use cvr_hvq::decode::Frame;
use cvr_hvq::{Geometry, Hvq, Parameters};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn a_cell_is_eight_fetches(
        size in [1_u32..20, 1_u32..9, 1_u32..9],
        codewords in [2_i64..700, 2_i64..700],
        stages in 1_u8..=3,
        bits in prop_oneof![Just(8), Just(16)],
        rgb: bool,
        seed: u32,
    ) {
        let volume = noise(size, if rgb { 3 } else { 1 }, seed);
        let settings: Settings = [
            ("coarse_codewords".to_owned(), SettingValue::Integer(codewords[0])),
            ("detail_codewords".to_owned(), SettingValue::Integer(codewords[1])),
            ("codeword_bits".to_owned(), SettingValue::Integer(bits)),
            ("iterations".to_owned(), SettingValue::Integer(1)),
        ].into_iter().collect();
        let stream = Arc::new(encode_temporary(&Hvq, &settings, &volume).unwrap());
        let parameters: Parameters = stream.parameters().unwrap();
        let decoder = Hvq.decoder(stream).unwrap();
        let resources = decoder.shader().unwrap().resources(FrameIndex::FIRST).unwrap();
        let geometry = Geometry::new(decoder.layout(), &parameters).unwrap();
        let (index, codebook) = (&resources[0].words, &resources[1].words);
        let frame = Frame { index, codebook, geometry: &geometry, stages };
        let same = cells_are_eight_fetches(
            decoder.layout().extent,
            |p| frame.fetch(p),
            |p, q| frame.fetch_cell(p, q),
        );
        prop_assert!(same.is_ok(), "{same:?}");
    }
}
