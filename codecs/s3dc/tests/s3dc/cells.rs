//! The cell function equals eight fetches, and a brick of any shape equals its voxels.

use std::sync::Arc;

use cvr_core::codec::{Codec as _, SettingValue, Settings, encode_temporary};
use cvr_core::conformance::{cells_are_eight_fetches, noise};
use cvr_core::kit::FetchVoxels as _;
use cvr_core::volume::FrameIndex;
use cvr_s3dc::decode::Frame;
use cvr_s3dc::{Geometry, S3dc};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn a_cell_is_eight_fetches(
        size in [1_u32..20, 1_u32..9, 1_u32..9],
        block in [1_u32..9, 1_u32..5, 1_u32..5],
        bits in prop_oneof![Just(1), Just(2), Just(4), Just(8)],
        rgb: bool,
        seed: u32,
    ) {
        let volume = noise(size, if rgb { 3 } else { 1 }, seed);
        let [x, y, z] = block;
        let settings: Settings = [
            ("block".to_owned(), SettingValue::Text(format!("{x}x{y}x{z}"))),
            ("index_bits".to_owned(), SettingValue::Integer(bits)),
        ].into_iter().collect();
        let stream = encode_temporary(&S3dc, &settings, &volume).unwrap();
        let decoder = S3dc.decoder(Arc::new(stream)).unwrap();
        let resources = decoder.shader().unwrap().resources(FrameIndex::FIRST).unwrap();
        let geometry =
            Geometry::new(decoder.layout(), settings.block("block").unwrap(), bits as u32).unwrap();
        let frame = Frame { minmax: &resources[0].words, index: &resources[1].words, geometry: &geometry };
        let same = cells_are_eight_fetches(
            decoder.layout().extent,
            |p| frame.fetch(p),
            |p, q| frame.fetch_cell(p, q),
        );
        prop_assert!(same.is_ok(), "{same:?}");
    }
}
