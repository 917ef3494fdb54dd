//! The cell equals eight fetches, and a brick of any shape equals its voxels.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

use std::sync::Arc;

use cvr_core::codec::{Codec as _, SettingValue, Settings, encode_temporary};
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, FrameIndex, SampleType, Samples, VolumeLayout};
use cvr_s3dc::decode::Frame;
use cvr_s3dc::{Geometry, S3dc};
use proptest::prelude::*;

fn volume(size: [u32; 3], channels: u32, seed: u32) -> FiniteVolume {
    let extent = Extent::try_from(size).unwrap();
    let layout = VolumeLayout { channels, ..VolumeLayout::scalar(extent, SampleType::U16) };
    let value = |i: u64| ((i as u32 ^ seed).wrapping_mul(0x9e37_79b9) >> 16) as u16;
    let samples = Samples::U16((0..layout.samples()).map(value).collect());
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

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
        let volume = volume(size, if rgb { 3 } else { 1 }, seed);
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
        for voxel in 0..decoder.layout().extent.voxels() as u32 {
            let p = [voxel % size[0], voxel / size[0] % size[1], voxel / size[0] / size[1]];
            for far in 0..8_u32 {
                let q = [0, 1, 2].map(|a| (p[a] + (far >> a & 1)).min(size[a] - 1));
                let cell = frame.fetch_cell(p, q);
                for (i, corner) in cell.into_iter().enumerate() {
                    let at = [0, 1, 2].map(|a: usize| if i >> a & 1 == 1 { q[a] } else { p[a] });
                    prop_assert_eq!(corner, frame.fetch(at));
                }
            }
        }
    }
}
