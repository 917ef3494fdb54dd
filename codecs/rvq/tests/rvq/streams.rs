//! Streams of every version so far, which must decode for ever to what they decoded to when they were kept.
//!
//! A stream that is kept is never written again. To keep one more, add it to the list and run with `CVR_BLESS=1`: the
//! file is written where there is none, and the test prints its checksum.

use cvr_codec_tests::kept::{Kept, assert_unchanged, checksums, with_flipped};
use cvr_core::codec::Settings;
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};
use cvr_rvq::Rvq;

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

const KEPT: [Kept<2>; 4] = [
    // 3 bits per code, so that codes lie in two words; cut blocks; entries of 16 bits; values that single precision rounds.
    Kept {
        name: "v1-f32-3-bits",
        version: 1,
        crc32c: [0x4b65_2b3e, 0xa513_05f2],
        made: || made(("3", "5", "16"), SampleType::F32, 1, 1),
    },
    // Colours, a table per frame.
    Kept {
        name: "v1-rgb-per-frame",
        version: 1,
        crc32c: [0xae86_5165, 0x36bf_d8bc],
        made: || made(("2", "9", "auto"), SampleType::I16, 3, 2),
    },
    // The payload variable: means, groups at the border, codes, escapes.
    Kept {
        name: "v1-f32-variable",
        version: 1,
        crc32c: [0x5600_d86b, 0x5600_d86b],
        made: || variable(("3", "4", "16"), SampleType::F32, 1, 1),
    },
    // Colours: an escape has three parts.
    Kept {
        name: "v1-rgb-variable-per-frame",
        version: 1,
        crc32c: [0x6122_5884, 0xd41c_f2be],
        made: || variable(("2", "4", "auto"), SampleType::I16, 3, 2),
    },
];

/// Blocks of a few patterns, which codebooks learn, some of noise, which they do not, and empty ones; cut by the border.
fn variable(
    (stages, codewords, entries): (&str, &str, &str),
    sample: SampleType,
    channels: u32,
    frames: u32,
) -> (Settings, FiniteVolume) {
    let settings = cvr_codec_tests::settings(&[
        ("payload", "variable"),
        ("psnr", "38"),
        ("stages", stages),
        ("codewords", codewords),
        ("entries", entries),
        ("tables", "per-frame"),
    ]);
    let extent = Extent::new(30, 22, 18).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, sample) };
    let hash = |n: u32| n.wrapping_mul(0x9e37_79b9) >> 18;
    let value = |i: u64| {
        let p = extent.position((i / u64::from(channels) % extent.voxels()) as usize);
        let block = p[0] / 4 + 8 * (p[1] / 4) + 48 * (p[2] / 4);
        let place = (p[0] % 4 + 4 * (p[1] % 4) + 16 * (p[2] % 4)) * channels + i as u32 % channels;
        (match hash(block + 1) % 16 {
            0 => hash(i as u32),
            1..=5 => 5000,
            kind => hash(place + 640 * (kind % 3)) / 2 + hash(i as u32) / 64,
        }) as i16
    };
    let values = (0..layout.samples()).map(value);
    let samples = match sample {
        SampleType::F32 => Samples::F32(values.map(|v| f32::from(v) * 0.123).collect()),
        _ => Samples::I16(values.collect()),
    };
    (settings, FiniteVolume::new(DenseVolume::new(layout, samples).unwrap()))
}

fn made(
    (stages, codewords, entries): (&str, &str, &str),
    sample: SampleType,
    channels: u32,
    frames: u32,
) -> (Settings, FiniteVolume) {
    let pairs = [("stages", stages), ("codewords", codewords), ("entries", entries), ("tables", "per-frame")];
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

/// Stages from which a stream is decoded, one after the other.
const STAGES: [u8; 2] = [1, u8::MAX];

#[test]
fn streams_that_were_kept_decode_to_what_they_did() {
    assert_unchanged(&Rvq, FOLDER, &KEPT, STAGES);
}

/// The checksum notices one value that is off by one bit of its code.
#[test]
fn another_codeword_has_another_checksum() {
    let kept = &KEPT[0];
    let changed = with_flipped(&Rvq, &kept.stream(&Rvq, FOLDER), "codebook", 0);
    assert_ne!(checksums(&Rvq, changed, STAGES), kept.crc32c);
}
