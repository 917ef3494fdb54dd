use std::path::Path;

use super::*;
use crate::codec::{CodecInfo, EncodeReport, Settings};
use crate::volume::{Extent, Replaced, SampleType, VolumeLayout};

const INFO: CodecInfo = CodecInfo {
    id: "probe",
    summary: "",
    stream_version: 1,
    decoded_by: &[],
    fetch_cell: false,
    paper: None,
    settings: &[],
    methods: &[],
};

fn write(path: &Path) -> Written {
    let mut writer = ContainerWriter::create(path).unwrap();
    let out: &mut dyn StreamWriter = &mut writer;
    out.append_words("b_words", &[1, 2, 3]).unwrap();
    out.append("a_bytes", Element::U8, &[7; 5]).unwrap();
    out.append_words("b_words", &[4, 5, 6]).unwrap();
    out.shape("b_words", &[2, 3]).unwrap();
    out.parameters(serde_json::json!({ "answer": 42 }));
    let layout = VolumeLayout::scalar(Extent::ONE, SampleType::U8);
    writer
        .finish(&INFO, &layout, &Settings::default(), &EncodeReport::default(), Replaced::default())
        .unwrap()
}

#[test]
fn what_was_written_comes_back() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("v.cvr");
    let written = write(&path);
    let volume = EncodedVolume::open(&path).unwrap();
    assert_eq!(written.file_bytes, volume.file_bytes());
    assert_eq!((volume.payload_bytes(), volume.file_bytes()), (6 * 4 + 5, 2048 + 6 * 4 + 5));
    assert_eq!(volume.tensor("b_words", Element::U32).unwrap().words(), [1, 2, 3, 4, 5, 6]);
    assert_eq!(volume.tensor("a_bytes", Element::U8).unwrap().bytes(), [7; 5]);
    assert_eq!(volume.parameters::<serde_json::Value>().unwrap()["answer"], 42);
    assert!(volume.tensor("a_bytes", Element::U32).is_err());
    assert!(volume.tensor("c", Element::U8).unwrap_err().to_string().contains("a_bytes, b_words"));
}

#[test]
fn the_safetensors_crate_reads_it() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("v.cvr");
    write(&path);
    let bytes = std::fs::read(&path).unwrap();
    let tensors = safetensors::SafeTensors::deserialize(&bytes).unwrap();
    let words = tensors.tensor("b_words").unwrap();
    assert_eq!(words.shape(), [2, 3]);
    assert_eq!(words.data()[20], 6);
}

#[test]
fn every_flipped_bit_is_noticed() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("v.cvr");
    write(&path);
    let bytes = std::fs::read(&path).unwrap();
    // Padding is spaces. A flip there makes the header invalid JSON, so no byte is exempt.
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        std::fs::write(&path, &damaged).unwrap();
        let result = EncodedVolume::open(&path);
        assert!(result.is_err(), "a flip in byte {at} of {} went unnoticed", bytes.len());
    }
}

#[test]
fn every_truncation_is_noticed() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("v.cvr");
    write(&path);
    let bytes = std::fs::read(&path).unwrap();
    for length in 0..bytes.len() {
        std::fs::write(&path, &bytes[..length]).unwrap();
        assert!(EncodedVolume::open(&path).is_err(), "cut to {length} bytes");
    }
    std::fs::write(&path, [bytes.as_slice(), b"x"].concat()).unwrap();
    assert!(EncodedVolume::open(&path).unwrap_err().to_string().contains("behind the last tensor"));
}

#[test]
fn nothing_is_left_behind_when_writing_fails() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("v.cvr");
    let mut writer = ContainerWriter::create(&path).unwrap();
    (&mut writer as &mut dyn StreamWriter).append_words("w", &[1, 2, 3]).unwrap();
    writer.shape("w", &[2, 2]).unwrap();
    let layout = VolumeLayout::scalar(Extent::ONE, SampleType::U8);
    let result =
        writer.finish(&INFO, &layout, &Settings::default(), &EncodeReport::default(), Replaced::default());
    assert!(result.unwrap_err().to_string().contains("do not fill the shape"));
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
}

#[test]
fn numbers_of_the_spec_come_back_bit_for_bit() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("v.cvr");
    let writer = ContainerWriter::create(&path).unwrap();
    let layout = VolumeLayout {
        spacing: [0.1 + 0.2, 1.0 / 3.0, 1e-7],
        ..VolumeLayout::scalar(Extent::ONE, SampleType::U8)
    };
    let report = EncodeReport {
        error_bound: Some(0.000_000_000_000_000_000_000_000_195_296_716_583_755_45),
        notes: vec![],
    };
    writer.finish(&INFO, &layout, &Settings::default(), &report, Replaced::default()).unwrap();
    let spec = EncodedVolume::open(&path).unwrap().spec().clone();
    assert_eq!(spec.layout, layout);
    assert_eq!(spec.report, report);
}
