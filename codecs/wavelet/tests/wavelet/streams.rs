//! Kept streams of every version. They must decode to the same values for ever, at every resolution.
//!
//! A kept stream is never rewritten. To add one, add it to the list and run with `CVR_BLESS=1`. This writes missing
//! files and prints their checksums:
//!
//! ```text
//! CVR_BLESS=1 cargo test -p cvr-wavelet --test wavelet streams
//! ```
//!
//! The streams of a version that nobody has yet may be deleted first (`rm codecs/wavelet/tests/streams/v1-*.cvr`), and are then
//! written anew.

use cvr_codec_tests::kept::{Kept, assert_unchanged, checksum_at, checksums, with_flipped};
use cvr_codec_tests::settings;
use cvr_core::codec::Codec as _;
use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};
use cvr_wavelet::Wavelet;

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

/// A stream, and the checksums of its first and its second resolution.
const KEPT: [(Kept<1>, u32); 10] = [
    // Contexts, and corrections of samples that miss a bound.
    (
        Kept {
            name: "v1-contexts-f32-corrections",
            version: 1,
            crc32c: [0x319a_9c21],
            made: || {
                let pairs = [("filter", "cdf-9-7"), ("decompositions", "2"), ("max_error", "0.4")];
                (settings(&pairs), volume(SampleType::F32, 1, 1))
            },
        },
        0x019b_60a2,
    ),
    (
        Kept {
            name: "v1-contexts-5-3-lossless",
            version: 1,
            crc32c: [0x1898_5596],
            made: || (settings(&[("filter", "5-3"), ("decompositions", "3")]), volume(SampleType::U8, 1, 1)),
        },
        0x20e2_148e,
    ),
    // Colours and frames, each with a step of its own.
    (
        Kept {
            name: "v1-contexts-rgb-frames",
            version: 1,
            crc32c: [0x3430_e936],
            made: || (settings(&[("psnr", "42"), ("decompositions", "2")]), volume(SampleType::I16, 3, 2)),
        },
        0x7917_342a,
    ),
    // The paper's quantiser as it is printed.
    (
        Kept {
            name: "v1-runs-octree-printed",
            version: 1,
            crc32c: [0x095a_4d8e],
            made: || {
                let coder = [("coder", "runs"), ("order", "octree"), ("filter", "cdf-2-6")];
                let scale = [("quality", "20"), ("quant_scale", "printed"), ("decompositions", "2")];
                (settings(&[coder, scale].concat()), volume(SampleType::U8, 1, 1))
            },
        },
        0x139f_a56b,
    ),
    (
        Kept {
            name: "v1-runs-daubechies-4",
            version: 1,
            crc32c: [0x6ece_a32d],
            made: || {
                let coder = [("coder", "runs"), ("filter", "daubechies-4"), ("quality", "220")];
                (settings(&[&coder[..], &[("decompositions", "1")]].concat()), volume(SampleType::U16, 1, 1))
            },
        },
        0xd6fa_dc3e,
    ),
    // Lines of odd length are padded.
    (
        Kept {
            name: "v1-deflate-coiflet-6",
            version: 1,
            crc32c: [0xc45c_464e],
            made: || {
                let coder = [("coder", "deflate"), ("filter", "coiflet-6"), ("quality", "240")];
                (settings(&[&coder[..], &[("decompositions", "3")]].concat()), volume(SampleType::U8, 1, 1))
            },
        },
        0xce06_a956,
    ),
    (
        Kept {
            name: "v1-arithmetic-haar",
            version: 1,
            crc32c: [0x4420_ec67],
            made: || {
                let coder = [("coder", "arithmetic"), ("filter", "haar"), ("psnr", "40")];
                (settings(&[&coder[..], &[("decompositions", "2")]].concat()), volume(SampleType::I8, 1, 1))
            },
        },
        0xf11f_4e2a,
    ),
    (
        Kept {
            name: "v1-zerotree-spline",
            version: 1,
            crc32c: [0xa94c_713f],
            made: || {
                let coder = [("coder", "zerotree"), ("filter", "cdf-spline-2-6"), ("psnr", "45")];
                (settings(&[&coder[..], &[("decompositions", "3")]].concat()), volume(SampleType::F32, 1, 1))
            },
        },
        0x1c5e_5598,
    ),
    // Blocks that decode on their own: lossless, and with a bound. They have one resolution.
    (
        Kept {
            name: "v1-blocks-haar-8",
            version: 1,
            crc32c: [0x1898_5596],
            made: || (settings(&[("block", "8"), ("filter", "haar")]), volume(SampleType::U8, 1, 1)),
        },
        0,
    ),
    (
        Kept {
            name: "v1-blocks-5-3-16-rgb-frames",
            version: 1,
            crc32c: [0x3d57_dfca],
            made: || {
                let pairs = [("block", "16"), ("filter", "5-3"), ("max_error", "40")];
                (settings(&pairs), volume(SampleType::I16, 3, 2))
            },
        },
        0,
    ),
];

/// A smooth hill with grain, which moves from frame to frame. Odd sizes.
fn volume(sample: SampleType, channels: u32, frames: u32) -> FiniteVolume {
    let extent = Extent::new(21, 14, 11).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, sample) };
    let value = |i: u64| {
        let (voxel, channel) = (i / u64::from(channels), (i % u64::from(channels)) as i32);
        let (frame, voxel) = ((voxel / extent.voxels()) as i32, (voxel % extent.voxels()) as usize);
        let [x, y, z] = extent.position(voxel).map(|n| n as i32);
        let hill = (120 - (x - 8 - frame).pow(2) - (y - 6 - channel).pow(2) - (z - 5).pow(2)).max(-20);
        hill + ((i as u32).wrapping_mul(0x9e37_79b9) >> 29) as i32
    };
    let values = (0..layout.samples()).map(value);
    let samples = match sample {
        SampleType::U8 => Samples::U8(values.map(|v| (v + 20) as u8).collect()),
        SampleType::I8 => Samples::I8(values.map(|v| v as i8).collect()),
        SampleType::U16 => Samples::U16(values.map(|v| (v + 20) as u16 * 400).collect()),
        SampleType::I16 => Samples::I16(values.map(|v| v as i16 * 150).collect()),
        _ => Samples::F32(values.map(|v| v as f32 * 0.123).collect()),
    };
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

/// Numbers of stages from which each stream is decoded.
const STAGES: [u8; 1] = [u8::MAX];

#[test]
fn streams_that_were_kept_decode_to_what_they_did() {
    assert_unchanged(&Wavelet, FOLDER, &KEPT.map(|(kept, _)| kept), STAGES);
}

#[test]
fn their_second_resolution_decodes_to_what_it_did() {
    let mut problems = Vec::new();
    for (kept, expected) in KEPT {
        let stream = kept.stream(&Wavelet, FOLDER);
        if Wavelet.resolutions(&stream.spec().settings) == 1 {
            assert_eq!(expected, 0, "{}: there is none", kept.name);
            continue;
        }
        let found = checksum_at(&Wavelet, stream, 1);
        if found != expected {
            problems.push(format!("{}: {found:#010x}, {expected:#010x} was kept", kept.name));
        }
    }
    assert!(problems.is_empty(), "checksums of the second resolution:\n{}", problems.join("\n"));
}

/// The checksum notices one bit.
#[test]
fn another_bit_has_another_checksum() {
    for (name, tensor, byte) in [("v1-zerotree-spline", "steps", 2), ("v1-blocks-haar-8", "bits", 90)] {
        let kept = KEPT.iter().map(|(kept, _)| kept).find(|kept| kept.name == name).unwrap();
        let changed = with_flipped(&Wavelet, &kept.stream(&Wavelet, FOLDER), tensor, byte);
        assert_ne!(checksums(&Wavelet, changed, STAGES), kept.crc32c);
    }
}
