//! The cell function equals eight fetches, for every index width and block position.

use std::sync::Arc;

use cvr_core::codec::{Codec as _, SettingValue, Settings, encode_temporary};
use cvr_core::conformance::{cells_are_eight_fetches, noise};
use cvr_core::kit::FetchVoxels as _;
use cvr_core::volume::FrameIndex;
use cvr_vq::decode::Frame;
use cvr_vq::{Geometry, Parameters, Vq};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn a_cell_is_eight_fetches(
        size in [1_u32..20, 1_u32..9, 1_u32..9],
        block in [1_u32..6, 1_u32..4, 1_u32..4],
        codewords in 2_i64..700,
        bits in prop_oneof![Just(8), Just(16)],
        rgb: bool,
        seed: u32,
    ) {
        let volume = noise(size, if rgb { 3 } else { 1 }, seed);
        let [x, y, z] = block;
        let settings: Settings = [
            ("block".to_owned(), SettingValue::Text(format!("{x}x{y}x{z}"))),
            ("codewords".to_owned(), SettingValue::Integer(codewords)),
            ("codeword_bits".to_owned(), SettingValue::Integer(bits)),
            ("iterations".to_owned(), SettingValue::Integer(1)),
        ].into_iter().collect();
        let stream = Arc::new(encode_temporary(&Vq, &settings, &volume).unwrap());
        let parameters: Parameters = stream.parameters().unwrap();
        let decoder = Vq.decoder(stream).unwrap();
        let resources = decoder.shader().unwrap().resources(FrameIndex::FIRST).unwrap();
        let geometry = Geometry::new(decoder.layout(), &parameters).unwrap();
        let frame = Frame { index: &resources[0].words, codebook: &resources[1].words, geometry: &geometry };
        let same = cells_are_eight_fetches(
            decoder.layout().extent,
            |p| frame.fetch(p),
            |p, q| frame.fetch_cell(p, q),
        );
        prop_assert!(same.is_ok(), "{same:?}");
    }
}
