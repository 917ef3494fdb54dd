//! What the encoder promises beyond the battery.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use cvr_codec_tests::{bytes, hash, settings};
use cvr_core::codec::{Codec as _, EncodeError, Progress, decode_frame, encode_file, encode_temporary};
use cvr_core::container::{Element, EncodedVolume};
use cvr_core::volume::{FiniteVolume, FrameIndex, NoReferences, Replaced};
use cvr_rvq::Rvq;
use cvr_rvq::stream::{Entries, Parameters};

fn encoded(volume: &FiniteVolume, pairs: &[(&str, &str)]) -> Arc<EncodedVolume> {
    Arc::new(encode_temporary(&Rvq, &settings(pairs), volume).unwrap())
}

fn decoded(stream: &Arc<EncodedVolume>, frame: u32) -> Vec<f32> {
    let decoder = Rvq.decoder(Arc::clone(stream)).unwrap();
    decode_frame(decoder.as_ref(), FrameIndex(frame), &NoReferences).unwrap()
}

fn parameters(stream: &EncodedVolume) -> Parameters {
    stream.parameters().unwrap()
}

fn frame_values(volume: &FiniteVolume, frame: u32) -> Vec<f32> {
    volume.dense().frame_values(FrameIndex(frame))
}

fn error(stream: &Arc<EncodedVolume>, volume: &FiniteVolume) -> f64 {
    let pairs = decoded(stream, 0).into_iter().zip(frame_values(volume, 0));
    pairs.map(|(d, s)| f64::from(d - s).powi(2)).sum()
}

/// Ground that changes slowly, and texture.
fn textured() -> FiniteVolume {
    bytes([32, 32, 32], 1, 1, |p, _, _| hash(p, 9) / 4 + (p[0] * 5) as u8)
}

#[test]
fn codes_are_packed_without_a_bit_to_spare() {
    let volume = textured();
    for (stages, codewords, bits) in [("4", "16", 4), ("3", "100", 7), ("1", "2", 1)] {
        let stream = encoded(&volume, &[("stages", stages), ("codewords", codewords)]);
        let count: usize = stages.parse().unwrap();
        let words = stream.tensor("index", Element::U32).unwrap().words().len();
        assert_eq!(words, (512 * count * bits).div_ceil(32), "{stages} stages of {codewords}");
    }
}

#[test]
fn as_many_codewords_as_blocks_are_lossless() {
    let volume = bytes([24, 12, 8], 1, 1, |p, _, _| ((p[0] / 4 + p[1] / 4 + p[2] / 4) % 6 * 40) as u8);
    let stream = encoded(&volume, &[("codewords", "16")]);
    assert_eq!(stream.spec().report.error_bound, Some(0.0));
    assert_eq!(decoded(&stream, 0), frame_values(&volume, 0));
    let table = &parameters(&stream).tables[0];
    assert_eq!(table.codewords, [6], "stages that have nothing to do are not stored");
    let notes = &stream.spec().report.notes;
    assert!(notes[0].contains("1 of 4 stages are stored"), "{notes:?}");
    assert!(notes[1].contains("6 codewords serve a stage where 16"), "{notes:?}");
}

#[test]
fn one_voxel_and_a_constant_volume_are_lossless() {
    for volume in [bytes([1, 1, 1], 3, 1, |_, c, _| 7 * c as u8), bytes([9, 5, 3], 1, 2, |_, _, _| 200)] {
        let stream = encoded(&volume, &[("entries", "16")]);
        assert_eq!(stream.spec().report.error_bound, Some(0.0));
        assert_eq!(decoded(&stream, 0), frame_values(&volume, 0));
    }
}

#[test]
fn beam_and_refinement_lower_the_error() {
    let volume = textured();
    let with = |beam, refinement| {
        let pairs = [("stages", "4"), ("codewords", "16"), ("beam", beam), ("refinement", refinement)];
        error(&encoded(&volume, &pairs), &volume)
    };
    let (greedy, wide, refined, both) = (with("1", "0"), with("8", "0"), with("1", "4"), with("8", "4"));
    assert!(wide < greedy && refined < greedy, "{wide} and {refined} of {greedy}");
    assert!(both < wide && both < refined, "{both} of {wide} and {refined}");
}

#[test]
fn entries_follow_the_channels() {
    let colours = bytes([16, 16, 16], 3, 1, |p, c, _| hash(p, c) / 2 + (p[0] * 4) as u8);
    for (asked, stored) in [("auto", Entries::Colours), ("8", Entries::Bits8), ("16", Entries::Bits16)] {
        let stream = encoded(&colours, &[("entries", asked), ("codewords", "16")]);
        assert_eq!(parameters(&stream).entries, stored);
        let words = stream.tensor("codebook", Element::U32).unwrap().words().len();
        let per_codeword = match stored {
            Entries::Bits8 => 48,
            Entries::Bits16 => 96,
            Entries::Colours => 64,
        };
        assert_eq!(words, 4 * 16 * per_codeword);
    }
    assert_eq!(parameters(&encoded(&textured(), &[])).entries, Entries::Bits8);
}

/// 64 blocks pay for 16 codewords, 32768 for 64: a codebook takes at most a quarter of the bits of its codes.
#[test]
fn codebooks_grow_with_the_volume() {
    let of = |edge: u32| {
        let volume = bytes([edge; 3], 1, 1, |p, _, _| hash(p, 2));
        let stream = encoded(&volume, &[("stages", "1"), ("iterations", "0"), ("beam", "1")]);
        parameters(&stream).tables[0].codewords[0]
    };
    assert_eq!((of(16), of(128)), (16, 64));
}

#[test]
fn frames_share_a_table_or_have_their_own() {
    let volume = bytes([16, 16, 16], 1, 3, |p, _, f| hash(p, f) / 4 + 60 * f as u8);
    let shared = encoded(&volume, &[("codewords", "8")]);
    let each = encoded(&volume, &[("codewords", "8"), ("tables", "per-frame")]);
    assert_eq!((parameters(&shared).tables.len(), parameters(&each).tables.len()), (1, 3));
    for frame in 0..3 {
        let error = |stream: &Arc<EncodedVolume>| -> f64 {
            let pairs = decoded(stream, frame).into_iter().zip(frame_values(&volume, frame));
            pairs.map(|(d, s)| f64::from(d - s).powi(2)).sum()
        };
        assert!(error(&each) < error(&shared), "frame {frame}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_file() {
    let volume = bytes([40, 33, 21], 1, 1, |p, _, _| hash(p, 9) / 8 + (p[0] * p[1] / 9) as u8);
    let folder = tempfile::tempdir().unwrap();
    let on = |threads: usize| {
        let path = folder.path().join(format!("{threads}.cvr"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let pairs = settings(&[("training_blocks", "300"), ("codewords", "40")]);
        pool.install(|| {
            encode_file(&Rvq, &pairs, &volume, Replaced::default(), &path, &Progress::silent()).unwrap();
        });
        std::fs::read(path).unwrap()
    };
    let one = on(1);
    assert!(one == on(2) && one == on(4), "the bytes depend on the number of threads");
}

#[test]
fn a_user_can_stop_the_training() {
    let (volume, flag, calls) = (textured(), AtomicBool::new(false), AtomicU32::new(0));
    // Reading and training report no voxels: the flag is raised long before the first block is coded.
    let run = Progress::new(
        |voxels| {
            assert_eq!(voxels, 0, "coding began");
            flag.store(calls.fetch_add(1, Ordering::Relaxed) > 10, Ordering::Relaxed);
        },
        Some(&flag),
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.cvr");
    let stopped = encode_file(&Rvq, &settings(&[]), &volume, Replaced::default(), &path, &run);
    assert!(matches!(stopped, Err(EncodeError::Cancelled)), "{stopped:?}");
    assert!(!path.exists());
}
