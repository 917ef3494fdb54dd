//! Streams of every version so far, which must decode for ever to what they decoded to when they were kept.
//!
//! A stream that is kept is never written again. To keep one more, add it to the list and run with `CVR_BLESS=1`: the
//! file is written where there is none, and the test prints its checksum.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

use std::path::{Path, PathBuf};
use std::sync::Arc;

use cvr_core::codec::{Codec as _, Progress, SettingValue, Settings, decode_stages, encode_file};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::{
    DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, Replaced, SampleType, Samples, VolumeLayout,
};
use cvr_hvq::Hvq;

/// A stream that is kept.
struct Kept {
    name: &'static str,
    version: u32,
    /// CRC-32C of all samples decoded from one, two and three stages, as little-endian singles, frame after frame.
    crc32c: [u32; 3],
    /// What it was made from.
    made: fn() -> (Settings, FiniteVolume),
}

const KEPT: [Kept; 2] = [
    // Indices of 3 and 5 bits, so that some lie in two words; cut blocks; values that single precision rounds.
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
    let settings = pairs.iter().map(|(n, v)| ((*n).to_owned(), SettingValue::from(*v))).collect();
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

fn path(kept: &Kept) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/streams").join(format!("{}.cvr", kept.name))
}

/// Checksums of what a stream decodes to.
fn checksums(stream: EncodedVolume) -> [u32; 3] {
    let decoder = Hvq.decoder(Arc::new(stream)).unwrap();
    [1, 2, 3].map(|stages| {
        (0..decoder.layout().frames).map(FrameIndex).fold(0, |crc, frame| {
            let values = decode_stages(decoder.as_ref(), frame, stages, &NoReferences).unwrap();
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
            crc32c::crc32c_append(crc, &bytes)
        })
    })
}

#[test]
fn streams_that_were_kept_decode_to_what_they_did() {
    let mut problems = Vec::new();
    for kept in &KEPT {
        let path = path(kept);
        if !path.exists() && std::env::var_os("CVR_BLESS").is_some() {
            let (settings, volume) = (kept.made)();
            encode_file(&Hvq, &settings, &volume, Replaced::default(), &path, &Progress::silent()).unwrap();
        }
        let stream = EncodedVolume::open(&path).unwrap();
        assert_eq!(stream.spec().stream_version, kept.version, "{}", kept.name);
        let found = checksums(stream);
        if found != kept.crc32c {
            problems.push(format!(
                "{}: the checksums are {found:#010x?}, {:#010x?} were kept",
                kept.name, kept.crc32c
            ));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// The checksums notice one value that is off by one bit of its code; what needs no codeword stays the same.
#[test]
fn another_codeword_has_another_checksum() {
    let kept = &KEPT[0];
    let stream = EncodedVolume::open(&path(kept)).unwrap();
    let (spec, folder) = (stream.spec().clone(), tempfile::tempdir().unwrap());
    let changed = folder.path().join("changed.cvr");
    let mut writer = cvr_core::container::ContainerWriter::create(&changed).unwrap();
    for (name, tensor) in &spec.tensors {
        use cvr_core::container::StreamWriter as _;
        let mut bytes = stream.tensor(name, tensor.element).unwrap().bytes().to_vec();
        bytes[0] ^= u8::from(name == "codebook");
        writer.append(name, tensor.element, &bytes).unwrap();
        writer.shape(name, &tensor.shape).unwrap();
        writer.parameters(spec.parameters.clone());
    }
    writer.finish(Hvq.info(), &spec.layout, &spec.settings, &spec.report, spec.replaced).unwrap();
    let [mean, coarse, detail] = checksums(EncodedVolume::open(&changed).unwrap());
    assert_eq!(mean, kept.crc32c[0]);
    assert!(coarse != kept.crc32c[1] && detail != kept.crc32c[2]);
}
