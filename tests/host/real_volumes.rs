//! Real volumes through reader, registry, codec and metrics. The figures were computed independently of this
//! implementation. Without `CVR_DATA` each test prints one line.

use std::path::PathBuf;

use cvr::input::open;
use cvr::registry::Names;
use cvr_core::codec::{SettingValue, Settings, encode_temporary};
use cvr_core::metrics::VolumeError;
use cvr_core::render::DecodedFrame;
use cvr_core::volume::{FiniteVolume, FrameIndex};

/// A file in the folder of real volumes.
fn file(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("CVR_DATA");
    if folder.is_none() {
        println!("skipped: {name} is not encoded, because CVR_DATA names no folder of real volumes");
    }
    folder.map(|f| PathBuf::from(f).join(name))
}

/// PSNR in dB of S3Dc. Its bound must hold.
fn psnr(volume: &FiniteVolume, block: i64, index_bits: i64) -> f64 {
    let names = Names::new().unwrap();
    let codec = names.codecs().get("s3dc").unwrap();
    let settings: Settings = [("block", block), ("index_bits", index_bits)]
        .map(|(name, value)| (name.to_owned(), SettingValue::Integer(value)))
        .into_iter()
        .collect();
    let stream = encode_temporary(codec.as_ref(), &settings, volume).unwrap();
    let bound = stream.spec().report.error_bound.unwrap();
    let decoder = codec.decoder(stream.into()).unwrap();
    let decoded = DecodedFrame::decode(decoder.as_ref(), FrameIndex::FIRST).unwrap();
    let error = VolumeError::compare(volume, [decoded.values()]);
    assert!(error.max_abs_error <= bound, "{settings}: {} of {bound}", error.max_abs_error);
    assert!(error.max_abs_error > 0.0, "{settings}: S3Dc loses something");
    error.psnr_db
}

fn check(name: &str, expected: [(i64, i64, f64); 4]) {
    let Some(path) = file(name) else { return };
    let volume = FiniteVolume::new(open(&path).unwrap());
    for (block, index_bits, decibels) in expected {
        let measured = psnr(&volume, block, index_bits);
        assert!(
            (measured - decibels).abs() < 0.1,
            "{name}, block {block}, {index_bits} bits: {measured:.3} dB, expected {decibels}"
        );
    }
}

#[test]
fn chest() {
    check("lidc_chest.mha", [(4, 2, 36.120), (4, 4, 49.919), (16, 2, 31.322), (16, 4, 44.734)]);
}

#[test]
fn head() {
    check("mr_vs.mhd", [(4, 2, 34.473), (4, 4, 48.480), (16, 2, 28.553), (16, 4, 42.164)]);
}
