//! Volumes of the stability atlas with the payload `variable` and no target: neighbouring volumes have about equal
//! quality, and no file is larger than half of its volume plus the overhead of a container.

use std::sync::Arc;

use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, decode_frame, encode_temporary};
use cvr_core::metrics::VolumeError;
use cvr_core::stability::{Subject, raw_bytes};
use cvr_core::volume::{BrickSource as _, FiniteVolume, FrameIndex, NoReferences};
use cvr_tvq::Tvq;

/// Bytes of the file, and PSNR in dB. Lossless counts as `LOSSLESS`.
fn measured(volume: &FiniteVolume, payload: &str) -> (u64, f64) {
    let stream = encode_temporary(&Tvq, &settings(&[("payload", payload)]), volume).unwrap();
    let bytes = stream.file_bytes();
    let decoder = Tvq.decoder(Arc::new(stream)).unwrap();
    let frames = (0..volume.layout().frames).map(FrameIndex);
    let decoded = frames.map(|frame| decode_frame(decoder.as_ref(), frame, &NoReferences).unwrap());
    (bytes, VolumeError::compare(volume, decoded).psnr_db.min(LOSSLESS))
}

/// Smaller errors do not matter.
const LOSSLESS: f64 = 60.0;

/// PSNRs at the first dial steps: the least and the greatest.
fn range(name: &str, steps: usize, edge: u32, payload: &str) -> (f64, f64) {
    let subject = Subject::named(name).unwrap();
    let found: Vec<f64> = (0..steps).map(|step| measured(&subject.volume(step, edge), payload).1).collect();
    println!("{name} of {edge}³, {payload}: {found:.2?} dB");
    found.iter().fold((f64::INFINITY, 0.0), |(least, most), v| (v.min(least), v.max(most)))
}

/// A sheet at any tilt, and a bump on any offset that leaves enough digits.
#[test]
fn neighbouring_volumes_come_back_alike() {
    for (name, steps, decibels) in [("sheet", 5, 12.0), ("offset", 4, 3.5)] {
        for edge in [32, 48] {
            let (least, most) = range(name, steps, edge, "variable");
            assert!(most - least <= decibels, "{name} of {edge}³: {least} to {most} dB");
            assert!(least > 40.0, "{name} of {edge}³: {least} dB");
        }
    }
}

/// The failing twin: a bump with noise is not a neighbour of a bump without.
#[test]
fn volumes_that_are_no_neighbours_are_told_apart() {
    let (least, most) = range("noise", 5, 32, "variable");
    assert!(most - least > 12.0, "{least} to {most} dB");
}

#[test]
fn no_file_is_larger_than_half_of_its_volume_and_a_header() {
    let mut most = 0.0_f64;
    for subject in Subject::all() {
        for (step, at) in subject.steps.iter().enumerate() {
            let volume = subject.volume(step, 24);
            let samples = volume.layout().bytes() as f64;
            let header = raw_bytes(volume.layout()) as f64 - samples;
            let (bytes, psnr) = measured(&volume, "variable");
            let part = (bytes as f64 - header) / samples;
            if part > most {
                most = part;
                println!("{} at {at}: {part:.3} of the volume, {psnr:.1} dB", subject.name);
            }
            assert!(part <= 0.5, "{} at {at}: {bytes} bytes of {samples}", subject.name);
        }
    }
    assert!(most > 0.2, "nothing was near: {most}");
}
