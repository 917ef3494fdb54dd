//! PSNR on real volumes, against figures computed independently of this implementation. Skips without `CVR_DATA`.

use std::io::Read as _;
use std::path::PathBuf;
use std::sync::Arc;

use cvr_core::codec::{Codec as _, SettingValue, Settings, decode_frame, encode_temporary};
use cvr_core::volume::{
    BrickSource as _, DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, SampleType, Samples,
    VolumeLayout,
};
use cvr_s3dc::S3dc;

fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("CVR_DATA").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: CVR_DATA names no folder of real volumes");
    }
    folder
}

fn volume(size: [u32; 3], sample: SampleType, bytes: &[u8]) -> FiniteVolume {
    let layout = VolumeLayout::scalar(Extent::try_from(size).unwrap(), sample);
    let samples = Samples::from_bytes(sample, bytes, false).unwrap();
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

/// PSNR in dB over max − min of the original, decoded values rounded.
fn psnr(volume: &FiniteVolume, block: &str, index_bits: i64) -> f64 {
    let settings: Settings = [
        ("block".to_owned(), SettingValue::from(block)),
        ("index_bits".to_owned(), SettingValue::Integer(index_bits)),
    ]
    .into_iter()
    .collect();
    let stream = Arc::new(encode_temporary(&S3dc, &settings, volume).unwrap());
    let bytes = stream.file_bytes();
    let bound = stream.spec().report.error_bound.unwrap();
    let decoder = S3dc.decoder(stream).unwrap();
    let decoded = decode_frame(decoder.as_ref(), FrameIndex::FIRST, &NoReferences).unwrap();
    let source = volume.dense().frame_values(FrameIndex::FIRST);
    let error = |(d, s): (&f32, &f32)| f64::from(d.round()) - f64::from(*s);
    let square: f64 = decoded.iter().zip(&source).map(|pair| error(pair).powi(2)).sum();
    let worst = decoded.iter().zip(&source).map(|pair| error(pair).abs()).fold(0.0, f64::max);
    assert!(worst <= bound, "block {block}, {index_bits} bits: error {worst}, promised {bound}");
    let psnr = 10.0 * (volume.range().span().powi(2) * source.len() as f64 / square).log10();
    let ratio = volume.layout().bytes() as f64 / bytes as f64;
    println!(
        "block {block}, {index_bits} bits: {psnr:.3} dB, ratio {ratio:.3}, worst error {worst} of {bound}"
    );
    psnr
}

#[test]
fn bonsai() {
    let Some(folder) = data() else { return };
    let file = std::fs::read(folder.join("bonsai.nrrd")).unwrap();
    let header = file.windows(2).position(|w| w == b"\n\n").unwrap() + 2;
    let mut bytes = Vec::new();
    flate2::read::MultiGzDecoder::new(&file[header..]).read_to_end(&mut bytes).unwrap();
    let volume = volume([256; 3], SampleType::U8, &bytes);
    for (block, bits, expected) in
        [("4", 4, 52.834), ("4", 2, 39.300), ("8", 4, 49.059), ("16", 4, 46.402), ("16", 2, 32.417)]
    {
        let actual = psnr(&volume, block, bits);
        assert!(
            (actual - expected).abs() < 0.1,
            "block {block}, {bits} bits: {actual} dB, expected {expected}"
        );
    }
}

#[test]
fn magnetic_resonance_head() {
    let Some(folder) = data() else { return };
    let file = std::fs::read(folder.join("mr_vs.zraw")).unwrap();
    let mut bytes = Vec::new();
    flate2::read::ZlibDecoder::new(&file[..]).read_to_end(&mut bytes).unwrap();
    let volume = volume([352, 416, 120], SampleType::U16, &bytes);
    // There is no peer's value: finer settings must be better, and the bound must hold.
    let coarse = psnr(&volume, "16", 2);
    let default = psnr(&volume, "16", 4);
    let fine = psnr(&volume, "4", 4);
    assert!(coarse < default && default < fine);
}
