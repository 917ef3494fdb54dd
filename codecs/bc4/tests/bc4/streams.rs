//! Kept streams of every version. They must decode to the same values for ever.
//!
//! A kept stream is never rewritten. To add one, add it to the list and run with `CVR_BLESS=1`. This writes missing
//! files and prints their checksums.

use cvr_bc4::BC4;
use cvr_codec_tests::kept::{Kept, assert_unchanged, checksums, with_flipped};
use cvr_codec_tests::settings;
use cvr_core::codec::Settings;
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

const KEPT: [Kept<1>; 2] = [
    // A range that single precision rounds, several frames, and blocks cut along both axes.
    Kept {
        name: "v1-f32-frames",
        version: 1,
        crc32c: [0x8c13_0ca4],
        made: || made("search", SampleType::F32, 1, 2),
    },
    // Colours of 8 bits, with the endpoints of the range.
    Kept {
        name: "v1-rgb-range",
        version: 1,
        crc32c: [0x0cae_bf39],
        made: || made("range", SampleType::I8, 3, 1),
    },
];

/// Stages from which a stream is decoded.
const STAGES: [u8; 1] = [1];

fn made(quality: &str, sample: SampleType, channels: u32, frames: u32) -> (Settings, FiniteVolume) {
    let extent = Extent::new(13, 7, 3).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, sample) };
    let value = |i: u64| ((i as u32).wrapping_mul(0x9e37_79b9) >> 26) as i8 - 40 + (i % 60) as i8;
    let values = (0..layout.samples()).map(value);
    let samples = match sample {
        SampleType::F32 => Samples::F32(values.map(|v| f32::from(v) * 0.123 - 7.0).collect()),
        _ => Samples::I8(values.collect()),
    };
    (settings(&[("quality", quality)]), FiniteVolume::new(DenseVolume::new(layout, samples).unwrap()))
}

#[test]
fn streams_that_were_kept_decode_to_what_they_did() {
    assert_unchanged(&BC4, FOLDER, &KEPT, STAGES);
}

/// The checksums detect one changed bit of an endpoint, and of an index.
#[test]
fn another_bit_has_another_checksum() {
    for byte in [0, 8 * 5 + 3] {
        let kept = &KEPT[0];
        let changed = with_flipped(&BC4, &kept.stream(&BC4, FOLDER), "blocks", byte);
        assert_ne!(checksums(&BC4, changed, STAGES), kept.crc32c, "byte {byte}");
    }
}
