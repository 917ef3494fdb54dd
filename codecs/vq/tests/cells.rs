//! The cell equals eight fetches, for every width of index and place of blocks.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

use std::sync::Arc;

use cvr_core::codec::{Codec as _, SettingValue, Settings, encode_temporary};
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, FrameIndex, SampleType, Samples, VolumeLayout};
use cvr_vq::decode::Frame;
use cvr_vq::{Geometry, Parameters, Vq};
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
        block in [1_u32..6, 1_u32..4, 1_u32..4],
        codewords in 2_i64..700,
        bits in prop_oneof![Just(8), Just(16)],
        rgb: bool,
        seed: u32,
    ) {
        let volume = volume(size, if rgb { 3 } else { 1 }, seed);
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
