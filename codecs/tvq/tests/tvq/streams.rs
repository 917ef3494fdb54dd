//! Kept streams of every version. They must decode to the same values for ever.
//!
//! A kept stream is never rewritten. To add one, add it to the list and run with `CVR_BLESS=1`. This writes missing
//! files and prints their checksums.

use cvr_codec_tests::kept::{Kept, assert_unchanged, checksums, with_flipped};
use cvr_core::codec::Settings;
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};
use cvr_tvq::Tvq;

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

const KEPT: [Kept<4>; 5] = [
    Kept {
        name: "v1-f32-fixed",
        version: 1,
        crc32c: [0xdc37_de8b, 0xdd41_5b5d, 0x8bbe_10e6, 0x1b3e_bf4d],
        made: || made(SampleType::F32, 1, 1, &[("index_bits", "5"), ("entry_bits", "16")]),
    },
    Kept {
        name: "v1-rgb-variable-per-frame",
        version: 1,
        crc32c: [0x9cfc_c21c, 0xd49e_72bb, 0x59c2_e5ae, 0xa82f_3540],
        made: || {
            let pairs =
                [("payload", "variable"), ("tables", "per-frame"), ("index_bits", "4"), ("rate", "10")];
            made(SampleType::I16, 3, 2, &pairs)
        },
    },
    // Scales of entries have a fraction.
    Kept {
        name: "v2-f32-fixed",
        version: 2,
        crc32c: [0xdc37_de8b, 0xb436_e6a7, 0x48c6_bd7c, 0xee00_328f],
        made: || made(SampleType::F32, 1, 1, &[("index_bits", "5"), ("codevectors", "partition")]),
    },
    Kept {
        name: "v2-rgb-variable",
        version: 2,
        crc32c: [0x353a_cd4f, 0xab70_d142, 0xda6d_68d0, 0x3906_3110],
        made: || {
            let pairs = [("payload", "variable"), ("entry_bits", "8"), ("index_bits", "4"), ("rate", "6")];
            made(SampleType::I16, 3, 2, &pairs)
        },
    },
    // Groups with masks, planes of one word, and blocks that are coded directly.
    Kept {
        name: "v3-rgb-variable-escaped",
        version: 3,
        crc32c: [0x353a_cd4f, 0xbd53_a6dd, 0xabd4_db02, 0x4b7f_1c38],
        made: || {
            let pairs = [("payload", "variable"), ("entry_bits", "8"), ("index_bits", "4"), ("rate", "9")];
            made(SampleType::I16, 3, 2, &pairs)
        },
    },
];

fn made(sample: SampleType, channels: u32, frames: u32, pairs: &[(&str, &str)]) -> (Settings, FiniteVolume) {
    let settings = cvr_codec_tests::settings(pairs);
    let extent = Extent::new(33, 18, 21).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, sample) };
    let value = |i: u64| {
        let noise = (i as u32).wrapping_mul(0x9e37_79b9) >> (20 + i as u32 / 97 % 9);
        (noise + i as u32 / 33 % 18 * 150) as i16 - 2000
    };
    let values = (0..layout.samples()).map(value);
    let samples = match sample {
        SampleType::F32 => Samples::F32(values.map(|v| f32::from(v) * 0.123).collect()),
        _ => Samples::I16(values.collect()),
    };
    (settings, FiniteVolume::new(DenseVolume::new(layout, samples).unwrap()))
}

/// Numbers of stages from which each stream is decoded.
const STAGES: [u8; 4] = [1, 2, 3, 4];

#[test]
fn streams_that_were_kept_decode_to_what_they_did() {
    assert_unchanged(&Tvq, FOLDER, &KEPT, STAGES);
}

/// The checksums detect one wrong entry of a codebook.
#[test]
fn another_codeword_has_another_checksum() {
    let kept = &KEPT[0];
    // The high byte of the first entry of the second codeword.
    let changed = with_flipped(&Tvq, &kept.stream(&Tvq, FOLDER), "codebook", 129);
    let found = checksums(&Tvq, changed, STAGES);
    assert_eq!(found[0], kept.crc32c[0], "means need no codebook");
    assert_ne!(found, kept.crc32c);
}
