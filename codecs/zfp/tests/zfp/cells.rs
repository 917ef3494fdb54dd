//! The cell function equals eight fetches, at every rate and block position.

use std::sync::Arc;

use cvr_core::codec::{Codec as _, SettingValue, Settings, decode_frame, encode_temporary};
use cvr_core::conformance::{cells_are_eight_fetches, noise};
use cvr_core::kit::FetchVoxels as _;
use cvr_core::volume::{FrameIndex, NoReferences};
use cvr_zfp::decode::Frame;
use cvr_zfp::{Geometry, Parameters, Zfp};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn a_cell_is_eight_fetches_and_a_frame_is_its_voxels(
        size in [1_u32..14, 1_u32..9, 1_u32..9],
        rate in 0.140625_f64..32.0,
        rgb: bool,
        seed: u32,
    ) {
        let volume = noise(size, if rgb { 3 } else { 1 }, seed);
        let settings: Settings = [("rate".to_owned(), SettingValue::Float(rate))].into_iter().collect();
        let stream = Arc::new(encode_temporary(&Zfp, &settings, &volume).unwrap());
        let parameters: Parameters = stream.parameters().unwrap();
        let decoder = Zfp.decoder(stream).unwrap();
        let resources = decoder.shader().unwrap().resources(FrameIndex::FIRST).unwrap();
        let geometry = Geometry::new(decoder.layout(), &parameters).unwrap();
        let frame = Frame { words: &resources[0].words, geometry: &geometry };
        let extent = decoder.layout().extent;
        let same = cells_are_eight_fetches(extent, |p| frame.fetch(p), |p, q| frame.fetch_cell(p, q));
        prop_assert!(same.is_ok(), "{same:?}");
        let channels = geometry.channels as usize;
        let whole = decode_frame(decoder.as_ref(), FrameIndex::FIRST, &NoReferences).unwrap();
        for (i, voxel) in whole.chunks_exact(channels).enumerate() {
            prop_assert!(frame.fetch(extent.position(i))[..channels] == *voxel, "voxel {i}");
        }
    }
}
