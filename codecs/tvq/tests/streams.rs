//! Streams of every version so far, which must decode for ever to what they decoded to when they were kept.
//!
//! A stream that is kept is never written again. To keep one more, add it to the list and run with `CVR_BLESS=1`: the
//! file is written where there is none, and the test prints its checksum.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

use cvr_codec_tests::kept::{checksums, compare, open, path, with_flipped};
use cvr_core::codec::Settings;
use cvr_core::container::EncodedVolume;
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};
use cvr_tvq::Tvq;

/// A stream that is kept.
struct Kept {
    name: &'static str,
    version: u32,
    /// CRC-32C of all samples decoded from one, two, three and four stages, as little-endian singles, frame after frame.
    crc32c: [u32; 4],
    /// Number type, channels, frames and settings that it was made with.
    made: (SampleType, u32, u32, &'static [(&'static str, &'static str)]),
}

const KEPT: [Kept; 2] = [
    Kept {
        name: "v1-f32-fixed",
        version: 1,
        crc32c: [0xdc37_de8b, 0xdd41_5b5d, 0x8bbe_10e6, 0x1b3e_bf4d],
        made: (SampleType::F32, 1, 1, &[("index_bits", "5"), ("entry_bits", "16")]),
    },
    Kept {
        name: "v1-rgb-variable-per-frame",
        version: 1,
        crc32c: [0x9cfc_c21c, 0xd49e_72bb, 0x59c2_e5ae, 0xa82f_3540],
        made: (
            SampleType::I16,
            3,
            2,
            &[("payload", "variable"), ("tables", "per-frame"), ("index_bits", "4"), ("rate", "10")],
        ),
    },
];

fn made(kept: &Kept) -> (Settings, FiniteVolume) {
    let (sample, channels, frames, pairs) = kept.made;
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

/// Stages from which a stream is decoded, one after the other.
const STAGES: [u8; 4] = [1, 2, 3, 4];

fn stream(kept: &Kept) -> EncodedVolume {
    open(&Tvq, &path(env!("CARGO_MANIFEST_DIR"), kept.name), || made(kept))
}

#[test]
fn streams_that_were_kept_decode_to_what_they_did() {
    let mut problems = Vec::new();
    for kept in &KEPT {
        let stream = stream(kept);
        assert_eq!(stream.spec().stream_version, kept.version, "{}", kept.name);
        problems.extend(compare(kept.name, checksums(&Tvq, stream, STAGES), kept.crc32c).err());
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// The checksums notice one entry of a codebook that is off.
#[test]
fn another_codeword_has_another_checksum() {
    let kept = &KEPT[0];
    // The high byte of the first entry of the second codeword.
    let changed = with_flipped(&Tvq, &stream(kept), "codebook", 129);
    let found = checksums(&Tvq, changed, STAGES);
    assert_eq!(found[0], kept.crc32c[0], "means need no codebook");
    assert_ne!(found, kept.crc32c);
}
