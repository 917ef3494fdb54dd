//! The cell equals eight fetches, and a brick of any shape equals its voxels.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

use std::sync::Arc;

use cvr_bc4::decode::Frame;
use cvr_bc4::{Bc4, Geometry, Scale};
use cvr_core::codec::{Codec as _, Settings, encode_temporary};
use cvr_core::conformance::{cells_are_eight_fetches, noise};
use cvr_core::volume::FrameIndex;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn a_cell_is_eight_fetches(size in [1_u32..20, 1_u32..14, 1_u32..5], rgb: bool, seed: u32) {
        let volume = noise(size, if rgb { 3 } else { 1 }, seed);
        let settings = Settings::default().complete(Bc4.info()).unwrap();
        let stream = encode_temporary(&Bc4, &settings, &volume).unwrap();
        let decoder = Bc4.decoder(Arc::new(stream)).unwrap();
        let resources = decoder.shader().unwrap().resources(FrameIndex::FIRST).unwrap();
        let geometry = Geometry::new(decoder.layout());
        let scale = Scale::over(volume.range());
        let frame = Frame { blocks: &resources[0].words, geometry: &geometry, scale: &scale };
        let same = cells_are_eight_fetches(
            decoder.layout().extent,
            |p| frame.fetch(p),
            |p, q| frame.fetch_cell(p, q),
        );
        prop_assert!(same.is_ok(), "{same:?}");
    }
}
