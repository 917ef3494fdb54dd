//! Kept streams of every version. They must decode to the same values for ever.
//!
//! A kept stream is never rewritten. To add one, add it to the list and run with `CVR_BLESS=1`. This writes missing
//! files and prints their checksums.

use cvr_codec_tests::kept::{Kept, assert_unchanged, checksums, with_flipped};
use cvr_core::codec::Settings;
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};
use cvr_vq::Vq;

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

const KEPT: [Kept<1>; 2] = [
    // 3 bits per index, so that some indices span two words; cut blocks; 16-bit values that single precision rounds.
    Kept {
        name: "v1-f32-3-bits",
        version: 1,
        crc32c: [0x33f6_c7be],
        made: || made("3x2x2", "5", "16", SampleType::F32, 1, 1),
    },
    // Colours, a table per frame, tables of unequal size.
    Kept {
        name: "v1-rgb-per-frame",
        version: 1,
        crc32c: [0x3e95_b705],
        made: || made("2", "256", "8", SampleType::I16, 3, 2),
    },
];

fn made(
    block: &str,
    codewords: &str,
    bits: &str,
    sample: SampleType,
    channels: u32,
    frames: u32,
) -> (Settings, FiniteVolume) {
    let pairs =
        [("block", block), ("codewords", codewords), ("codeword_bits", bits), ("tables", "per-frame")];
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
const STAGES: [u8; 1] = [u8::MAX];

#[test]
fn streams_that_were_kept_decode_to_what_they_did() {
    assert_unchanged(&Vq, FOLDER, &KEPT, STAGES);
}

/// The checksum detects one value whose code is off by one bit.
#[test]
fn another_codeword_has_another_checksum() {
    let kept = &KEPT[0];
    let changed = with_flipped(&Vq, &kept.stream(&Vq, FOLDER), "codebook", 0);
    assert_ne!(checksums(&Vq, changed, STAGES), kept.crc32c);
}
