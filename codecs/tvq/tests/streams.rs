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
use cvr_tvq::Tvq;

/// A stream that is kept.
struct Kept {
    name: &'static str,
    version: u32,
    /// CRC-32C of all decoded samples, as little-endian singles, frame after frame, stage after stage.
    crc32c: u32,
    /// Number type, channels, frames and settings that it was made with.
    made: (SampleType, u32, u32, &'static [(&'static str, &'static str)]),
}

const KEPT: [Kept; 2] = [
    Kept {
        name: "v1-f32-fixed",
        version: 1,
        crc32c: 0x7c37_70d9,
        made: (SampleType::F32, 1, 1, &[("index_bits", "5"), ("entry_bits", "16")]),
    },
    Kept {
        name: "v1-rgb-variable-per-frame",
        version: 1,
        crc32c: 0xfb46_ef20,
        made: (
            SampleType::I16,
            3,
            2,
            &[("payload", "variable"), ("tables", "per-frame"), ("index_bits", "4"), ("rate", "6")],
        ),
    },
];

fn made(kept: &Kept) -> (Settings, FiniteVolume) {
    let (sample, channels, frames, pairs) = kept.made;
    let settings = pairs.iter().map(|(n, v)| ((*n).to_owned(), SettingValue::from(*v))).collect();
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

fn path(kept: &Kept) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/streams").join(format!("{}.cvr", kept.name))
}

/// Checksum of what a stream decodes to.
fn checksum(stream: EncodedVolume) -> u32 {
    let decoder = Tvq.decoder(Arc::new(stream)).unwrap();
    let frames = (0..decoder.layout().frames).map(FrameIndex);
    frames.flat_map(|frame| (1..=4).map(move |stages| (frame, stages))).fold(0, |crc, (frame, stages)| {
        let values = decode_stages(decoder.as_ref(), frame, stages, &NoReferences).unwrap();
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        crc32c::crc32c_append(crc, &bytes)
    })
}

#[test]
fn streams_that_were_kept_decode_to_what_they_did() {
    let mut problems = Vec::new();
    for kept in &KEPT {
        let path = path(kept);
        if !path.exists() && std::env::var_os("CVR_BLESS").is_some() {
            let (settings, volume) = made(kept);
            encode_file(&Tvq, &settings, &volume, Replaced::default(), &path, &Progress::silent()).unwrap();
        }
        let stream = EncodedVolume::open(&path).unwrap();
        assert_eq!(stream.spec().stream_version, kept.version, "{}", kept.name);
        let found = checksum(stream);
        if found != kept.crc32c {
            problems.push(format!(
                "{}: the checksum is {found:#010x}, {:#010x} was kept",
                kept.name, kept.crc32c
            ));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// The checksum notices one entry of a codebook that is off.
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
        // The high byte of the first entry of the second codeword.
        if name == "codebook" {
            bytes[129] ^= 1;
        }
        writer.append(name, tensor.element, &bytes).unwrap();
        writer.shape(name, &tensor.shape).unwrap();
        writer.parameters(spec.parameters.clone());
    }
    writer.finish(Tvq.info(), &spec.layout, &spec.settings, &spec.report, spec.replaced).unwrap();
    assert_ne!(checksum(EncodedVolume::open(&changed).unwrap()), kept.crc32c);
}
