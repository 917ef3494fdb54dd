//! Kept streams of every version. They must decode to the same values for ever.
//!
//! A kept stream is never rewritten. To add one, add it to the list and run with `CVR_BLESS=1`. This writes missing
//! files and prints their checksums.

use cvr_codec_tests::kept::{Kept, assert_unchanged, checksums, with_flipped};
use cvr_core::codec::Settings;
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};
use cvr_zfp::Zfp;

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

const KEPT: [Kept<1>; 2] = [
    // Blocks of 70 bits, so that only the first begins on a word; cut blocks.
    Kept {
        name: "v1-f32-70-bits",
        version: 1,
        crc32c: [0xa076_9084],
        made: || made("1.1", SampleType::F32, 1, 1),
    },
    // Colours and frames.
    Kept {
        name: "v1-rgb-frames",
        version: 1,
        crc32c: [0x81ba_a281],
        made: || made("4", SampleType::I16, 3, 2),
    },
];

fn made(rate: &str, sample: SampleType, channels: u32, frames: u32) -> (Settings, FiniteVolume) {
    let extent = Extent::new(13, 7, 5).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, sample) };
    let value = |i: u64| ((i as u32).wrapping_mul(0x9e37_79b9) >> 18) as i16 - 7000;
    let values = (0..layout.samples()).map(value);
    let samples = match sample {
        SampleType::F32 => Samples::F32(values.map(|v| f32::from(v) * 0.123).collect()),
        _ => Samples::I16(values.collect()),
    };
    let settings = cvr_codec_tests::settings(&[("rate", rate)]);
    (settings, FiniteVolume::new(DenseVolume::new(layout, samples).unwrap()))
}

/// Numbers of stages from which each stream is decoded.
const STAGES: [u8; 1] = [u8::MAX];

#[test]
fn streams_that_were_kept_decode_to_what_they_did() {
    assert_unchanged(&Zfp, FOLDER, &KEPT, STAGES);
}

/// The checksum notices one bit.
#[test]
fn another_bit_has_another_checksum() {
    let kept = &KEPT[0];
    let changed = with_flipped(&Zfp, &kept.stream(&Zfp, FOLDER), "blocks", 1);
    assert_ne!(checksums(&Zfp, changed, STAGES), kept.crc32c);
}
