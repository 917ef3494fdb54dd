//! Cells, rows and boxes are their voxels.

use std::sync::Arc;

use cvr_bc4::BC4;
use cvr_core::codec::{Codec as _, Settings, encode_temporary};
use cvr_core::conformance::noise;
use cvr_core::volume::{BrickKey, Extent, FrameIndex, NoReferences, Region};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn a_box_of_any_shape_is_its_voxels(size in [1_u32..20, 1_u32..14, 1_u32..5], rgb: bool, seed: u32) {
        let volume = noise(size, if rgb { 3 } else { 1 }, seed);
        let stream = encode_temporary(&BC4, &Settings::default(), &volume).unwrap();
        let decoder = BC4.decoder(Arc::new(stream)).unwrap();
        let channels = decoder.layout().channels as usize;
        let decoded = |region: Region| {
            let mut out = vec![f32::NAN; region.extent.voxels() as usize * channels];
            decoder.decode_brick(BrickKey::full(FrameIndex::FIRST, region), &NoReferences, &mut out).unwrap();
            out
        };
        for origin in Region::whole(decoder.layout().extent).positions() {
            let rest: [u32; 3] = std::array::from_fn(|a| size[a] - origin[a]);
            for size in [rest.map(|r| r.min(2)), [rest[0], 1, 1], [rest[0].min(5), rest[1].min(3), 1]] {
                let region = Region { origin, extent: Extent::try_from(size).unwrap() };
                let voxels = region.positions().flat_map(|p| decoded(Region::voxel(p)));
                prop_assert!(voxels.eq(decoded(region)), "{region:?}");
            }
        }
    }
}
