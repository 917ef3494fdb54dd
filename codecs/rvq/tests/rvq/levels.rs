//! Stages and resolutions: what a part of a stream decodes to.

use std::sync::Arc;

use cvr_codec_tests::{bytes, hash, settings};
use cvr_core::codec::{Codec as _, Decoder, encode_temporary};
use cvr_core::volume::{BrickKey, FiniteVolume, FrameIndex, Level, NoReferences, Region};
use cvr_rvq::Rvq;

/// Smooth ground with texture, so that every stage has something to do.
fn volume(channels: u32) -> FiniteVolume {
    bytes([30, 21, 18], channels, 1, |p, c, _| {
        let wave =
            (f64::from(p[0]) / 4.0).sin() + (f64::from(p[1] + 3 * c) / 5.0).cos() + f64::from(p[2]) / 9.0;
        (100.0 + 30.0 * wave) as u8 + hash(p, c) / 32
    })
}

fn decoder(volume: &FiniteVolume, pairs: &[(&str, &str)]) -> Box<dyn Decoder> {
    Rvq.decoder(Arc::new(encode_temporary(&Rvq, &settings(pairs), volume).unwrap())).unwrap()
}

fn decoded(decoder: &dyn Decoder, level: Level) -> Vec<f32> {
    let layout = decoder.layout().at_resolution(level.resolution);
    let region = Region::whole(layout.extent);
    let mut out = vec![0.0; (region.extent.voxels() * u64::from(layout.channels)) as usize];
    decoder
        .decode_brick(BrickKey { frame: FrameIndex::FIRST, level, region }, &NoReferences, &mut out)
        .unwrap();
    out
}

fn square(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / a.len() as f64
}

#[test]
fn every_stage_lowers_the_error() {
    for (channels, refinement, beam) in [(1, "0", "1"), (1, "4", "1"), (1, "4", "8"), (3, "4", "4")] {
        let volume = volume(channels);
        let pairs = [("stages", "6"), ("codewords", "16"), ("refinement", refinement), ("beam", beam)];
        let decoder = decoder(&volume, &pairs);
        let source = volume.dense().frame_values(FrameIndex::FIRST);
        let errors: Vec<f64> = (1..=6)
            .map(|stages| square(&decoded(decoder.as_ref(), Level { resolution: 0, stages }), &source))
            .collect();
        assert!(
            errors.windows(2).all(|pair| pair[1] < pair[0]),
            "{channels} {refinement} {beam}: {errors:?}"
        );
        let all = decoded(decoder.as_ref(), Level::FULL);
        assert_eq!(square(&all, &source), errors[5], "more stages than there are is all");
    }
}

/// A voxel of a coarser level is the mean of those that it stands for, but for the rounding of each stage's entries, and where
/// sums beyond the range of the volume are cut off.
#[test]
fn a_coarser_level_is_the_mean_of_the_finer() {
    for (channels, entries, tolerance) in [(1, "8", 2.0), (1, "16", 0.1), (3, "auto", 0.5), (3, "16", 0.1)] {
        let volume = volume(channels);
        let decoder = decoder(&volume, &[("codewords", "32"), ("entries", entries), ("stages", "3")]);
        let (channels, mut compared) = (channels as usize, 0);
        for resolution in [1_u8, 2] {
            let fine = decoded(decoder.as_ref(), Level { resolution: resolution - 1, ..Level::FULL });
            let coarse = decoded(decoder.as_ref(), Level { resolution, ..Level::FULL });
            let [from, to] = [resolution - 1, resolution].map(|r| decoder.layout().extent.at_resolution(r));
            for (n, p) in Region::whole(to).positions().enumerate() {
                let inside = (0..3).all(|a| 2 * p[a] + 1 < from.to_array()[a]);
                for c in (0..channels).filter(|_| inside) {
                    let corner =
                        |i: u32| fine[from.index([0, 1, 2].map(|a| 2 * p[a] + (i >> a & 1))) * channels + c];
                    let corners: Vec<f32> = (0..8).map(corner).collect();
                    let range = volume.range();
                    if corners.iter().any(|v| *v <= range.min || *v >= range.max) {
                        continue;
                    }
                    let mean = corners.iter().sum::<f32>() / 8.0;
                    compared += 1;
                    let found = coarse[n * channels + c];
                    assert!(
                        (found - mean).abs() <= tolerance,
                        "{entries} {resolution} {p:?}: {found}, mean {mean}"
                    );
                }
            }
        }
        assert!(compared > 500, "{compared} voxels");
    }
}
