//! Streams and decoded values equal zfp's bit for bit, by checksums that `reference/reference.py` wrote. Real volumes
//! are skipped without `CVR_DATA`. The test that runs zfp itself is skipped without a Python that has `zfpy`.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use cvr_codec_tests::kept::with_flipped;
use cvr_codec_tests::real::{NAMES, folder, volume_of};
use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, decode_frame, encode_temporary};
use cvr_core::container::{Element, EncodedVolume};
use cvr_core::volume::{
    BrickSource as _, DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, SampleType, Samples,
    VolumeLayout,
};
use cvr_zfp::Zfp;
use serde_json::Value;
use sha2::{Digest as _, Sha256};

fn reference() -> Value {
    serde_json::from_str(include_str!("../reference/reference.json")).unwrap()
}

fn digest(parts: impl Iterator<Item = Vec<u8>>) -> String {
    let sum = parts.fold(Sha256::new(), Sha256::chain_update).finalize();
    sum.iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}

/// Bytes of the channels, one after another. Zeros of either sign are equal.
fn planes(values: &[f32], channels: u32) -> Vec<Vec<u8>> {
    let plane = |c: u32| {
        let mut bytes = Vec::with_capacity(values.len() * 4 / channels as usize);
        for value in values.iter().skip(c as usize).step_by(channels as usize) {
            bytes.extend_from_slice(&(value + 0.0).to_le_bytes());
        }
        bytes
    };
    (0..channels).map(plane).collect()
}

fn samples(volume: &FiniteVolume) -> String {
    let layout = volume.layout();
    let frame = |f| volume.dense().frame_values(FrameIndex(f));
    digest((0..layout.frames).flat_map(|f| planes(&frame(f), layout.channels)))
}

fn encoded(volume: &FiniteVolume, rate: &str) -> EncodedVolume {
    encode_temporary(&Zfp, &settings(&[("rate", rate)]), volume).unwrap()
}

/// Checksums of the stream and of its decoded values.
fn found(stream: EncodedVolume) -> [String; 2] {
    let bits = stream.tensor("blocks", Element::U32).unwrap().bytes().to_vec();
    let decoder = Zfp.decoder(Arc::new(stream)).unwrap();
    let layout = decoder.layout();
    let frame = |f| decode_frame(decoder.as_ref(), FrameIndex(f), &NoReferences).unwrap();
    let decoded = (0..layout.frames).flat_map(|f| planes(&frame(f), layout.channels));
    [digest([bits].into_iter()), digest(decoded)]
}

/// Compares a volume with its entry at each rate. Returns the number of rates.
fn holds(name: &str, entry: &Value, volume: &FiniteVolume) -> usize {
    assert_eq!(entry["samples"], samples(volume), "{name}: this is not the volume that zfp was given");
    let rates = entry["rates"].as_object().unwrap();
    for (rate, expected) in rates {
        let [stream, decoded] = found(encoded(volume, rate));
        assert_eq!(expected["stream"], stream, "{name} at rate {rate}: the streams differ");
        assert_eq!(expected["decoded"], decoded, "{name} at rate {rate}: the decoded values differ");
    }
    rates.len()
}

/// The volumes of `reference.py`.
fn generated(kind: &str, size: [u32; 3]) -> FiniteVolume {
    let extent = Extent::try_from(size).unwrap();
    let value = |p: [u32; 3]| -> f64 {
        let h = p.iter().fold(0x9e37_79b9_u32, |h, v| {
            let h = (h ^ v).wrapping_mul(0x85eb_ca6b);
            let h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
            h ^ h >> 16
        });
        let signed = f64::from(h >> 8) - f64::from(1 << 23);
        match kind {
            "zero" => 0.0,
            "constant" => 77.0,
            "ramp" => f64::from(p[0] + 2 * p[1] + 3 * p[2]),
            "bytes" => f64::from(h >> 24),
            "signed" => signed,
            "tiny" => signed * 2_f64.powi(-100),
            "large" => signed * 2_f64.powi(100),
            "sparse" if !(p[0] / 4 + p[1] / 4 + p[2] / 4).is_multiple_of(3) => 0.0,
            "sparse" => f64::from(h >> 20) - 2048.0,
            "magnitudes" => (f64::from(h >> 16) - f64::from(1 << 15)) * 2_f64.powi((h & 63) as i32 - 40),
            other => panic!("no kind {other}"),
        }
    };
    let values = (0..extent.voxels() as usize).map(|i| value(extent.position(i)) as f32).collect();
    let layout = VolumeLayout::scalar(extent, SampleType::F32);
    FiniteVolume::new(DenseVolume::new(layout, Samples::F32(values)).unwrap())
}

/// The entries of generated volumes, with their volumes.
fn all_generated(reference: &Value) -> Vec<(String, Value, FiniteVolume)> {
    let entries = reference["volumes"].as_object().unwrap().iter();
    let of_entry = |(name, entry): (&String, &Value)| {
        let (kind, size) = name.split_once(' ')?;
        let size: Vec<u32> = size.split('x').map(|n| n.parse().unwrap()).collect();
        Some((name.clone(), entry.clone(), generated(kind, size.try_into().unwrap())))
    };
    entries.filter_map(of_entry).collect()
}

#[test]
fn generated_volumes_equal_zfp() {
    let all = all_generated(&reference());
    let rates: usize = all.iter().map(|(name, entry, volume)| holds(name, entry, volume)).sum();
    assert_eq!((all.len(), rates), (24, 24 * 8));
}

#[test]
fn real_volumes_equal_zfp() {
    let Some(folder) = folder() else { return };
    let reference = reference();
    for name in NAMES {
        assert_eq!(holds(name, &reference["volumes"][name], &volume_of(&folder, name)), 4);
    }
}

/// The comparison detects a single bit, and another rate.
#[test]
fn another_bit_or_rate_is_seen() {
    let reference = reference();
    let name = "signed 13x17x23";
    let expected = &reference["volumes"][name]["rates"]["2"];
    let volume = generated("signed", [13, 17, 23]);
    let right = encoded(&volume, "2");
    // Of the first block: bits of the exponent, and a bit of a plane.
    for byte in [1, 4] {
        let [stream, decoded] = found(with_flipped(&Zfp, &right, "blocks", byte));
        assert!(expected["stream"] != stream && expected["decoded"] != decoded, "byte {byte}");
    }
    for rate in ["1", "4", "2.015625"] {
        let [stream, decoded] = found(encoded(&volume, rate));
        assert!(expected["stream"] != stream && expected["decoded"] != decoded, "rate {rate}");
    }
}

/// The checksums equal those of zfp itself, if it is installed.
#[test]
fn zfp_itself_says_so() {
    let python = |arguments: &[&str]| Command::new("python3").args(arguments).output();
    if !python(&["-c", "import numpy, zfpy"]).is_ok_and(|output| output.status.success()) {
        println!("skipped: there is no python3 with numpy and zfpy");
        return;
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/reference.py");
    let mut arguments = vec![script.to_str().unwrap().to_owned()];
    arguments.extend(folder().map(|folder| folder.to_str().unwrap().to_owned()));
    let output = python(&arguments.iter().map(String::as_str).collect::<Vec<_>>()).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let says: Value = serde_json::from_slice(&output.stdout).unwrap();
    let reference = reference();
    let volumes = says["volumes"].as_object().unwrap();
    assert!(volumes.len() >= 24);
    for (name, entry) in volumes {
        assert_eq!(entry, &reference["volumes"][name], "{name}");
    }
}
