//! The cell function equals eight fetches, for both payloads, every number of stages and block position, in several
//! sub-volumes.

use std::sync::Arc;

use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, encode_temporary};
use cvr_core::conformance::{cells_are_eight_fetches, noise};
use cvr_core::kit::FetchVoxels as _;
use cvr_core::volume::{Extent, FrameIndex};
use cvr_tvq::decode::Frame;
use cvr_tvq::{Geometry, Parameters, Tvq};
use proptest::prelude::*;

/// Compares every cell of noise under these settings with eight fetches, at every number of stages.
fn check(size: [u32; 3], channels: u32, seed: u32, pairs: &[(&str, &str)]) -> Result<Extent, String> {
    let volume = noise(size, channels, seed);
    let stream = Arc::new(encode_temporary(&Tvq, &settings(pairs), &volume).unwrap());
    let parameters: Parameters = stream.parameters().unwrap();
    let decoder = Tvq.decoder(stream).unwrap();
    let resources = decoder.shader().unwrap().resources(FrameIndex::FIRST).unwrap();
    let geometry = Geometry::new(decoder.layout(), &parameters).unwrap();
    for stages in 1..=4 {
        let [tables, codebook, index, heads] = [0, 1, 2, 3].map(|i: usize| resources[i].words.as_ref());
        let frame = Frame { tables, codebook, index, heads, stages, geometry: &geometry };
        let extent = decoder.layout().extent;
        cells_are_eight_fetches(extent, |p| frame.fetch(p), |p, q| frame.fetch_cell(p, q))?;
    }
    Ok(geometry.sub_grid)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn a_cell_is_eight_fetches(
        size in [1_u32..20, 1_u32..9, 1_u32..9],
        variable: bool,
        directly: bool,
        index_bits in 4_u32..9,
        deep: bool,
        rgb: bool,
        seed: u32,
    ) {
        let same = check(size, if rgb { 3 } else { 1 }, seed, &[
            ("payload", if variable { "variable" } else { "fixed" }),
            ("rate", if variable && !directly { "4" } else { "0" }),
            ("psnr", if variable && directly { "50" } else { "0" }),
            ("index_bits", &index_bits.to_string()),
            ("entry_bits", if deep { "16" } else { "8" }),
            ("iterations", "1"),
        ]);
        prop_assert!(same.is_ok(), "{same:?}");
    }
}

/// Cells that reach from one sub-volume into the next.
#[test]
fn a_cell_across_sub_volumes_is_eight_fetches() {
    for payload in ["fixed", "variable"] {
        let pairs = [("payload", payload), ("subvolume", "128"), ("index_bits", "4"), ("iterations", "1")];
        let sub_grid = check([133, 5, 4], 1, 7, &pairs).unwrap();
        assert_eq!(sub_grid.voxels(), 2, "{payload}");
    }
}
