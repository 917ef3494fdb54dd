//! Kept streams of every version. They must decode to the same values for ever.
//!
//! A kept stream is never rewritten. To add one, add it to the list and run with `CVR_BLESS=1`. This writes missing
//! files and prints their checksums.

use cvr_codec_tests::kept::{Kept, assert_unchanged, checksums, with_flipped};
use cvr_core::codec::Settings;
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};
use cvr_hvq::Hvq;

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

const KEPT: [Kept<3>; 2] = [
    // Indices of 3 and 5 bits, so that some span two words; cut blocks; values that single precision rounds.
    Kept {
        name: "v1-f32-3-and-5-bits",
        version: 1,
        crc32c: [0x4ff8_3cfc, 0x1716_f6a7, 0x139e_94b5],
        made: || made(["5", "17"], "8", "16", SampleType::F32, 1, 1),
    },
    // Colours, tables per frame of unequal size, means of 16 bits.
    Kept {
        name: "v1-rgb-per-frame",
        version: 1,
        crc32c: [0x2de2_5948, 0xca94_cde9, 0xc1b2_c02c],
        made: || made(["256", "6"], "16", "8", SampleType::I16, 3, 2),
    },
];

fn made(
    codewords: [&str; 2],
    mean_bits: &str,
    bits: &str,
    sample: SampleType,
    channels: u32,
    frames: u32,
) -> (Settings, FiniteVolume) {
    let pairs = [
        ("coarse_codewords", codewords[0]),
        ("detail_codewords", codewords[1]),
        ("mean_bits", mean_bits),
        ("codeword_bits", bits),
        ("tables", "per-frame"),
    ];
    let settings = cvr_codec_tests::settings(&pairs);
    let extent = Extent::new(13, 7, 5).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, sample) };
    let value =
        |i: u64| ((i as u32 / (1 + i as u32 / 1400 * 40)).wrapping_mul(0x9e37_79b9) >> 18) as i16 - 7000;
    let values = (0..layout.samples()).map(value);
    let samples = match sample {
        SampleType::F32 => Samples::F32(values.map(|v| f32::from(v) * 0.123).collect()),
        _ => Samples::I16(values.collect()),
    };
    (settings, FiniteVolume::new(DenseVolume::new(layout, samples).unwrap()))
}

/// Numbers of stages from which each stream is decoded.
const STAGES: [u8; 3] = [1, 2, 3];

#[test]
fn streams_that_were_kept_decode_to_what_they_did() {
    assert_unchanged(&Hvq, FOLDER, &KEPT, STAGES);
}

/// The checksums detect one value whose code is off by one bit. Values without codewords stay the same.
#[test]
fn another_codeword_has_another_checksum() {
    let kept = &KEPT[0];
    let changed = with_flipped(&Hvq, &kept.stream(&Hvq, FOLDER), "codebook", 0);
    let [mean, coarse, detail] = checksums(&Hvq, changed, STAGES);
    assert_eq!(mean, kept.crc32c[0]);
    assert!(coarse != kept.crc32c[1] && detail != kept.crc32c[2]);
}
