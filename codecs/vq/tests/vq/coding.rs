//! Properties of the encoder beyond the conformance tests: lossless if the codebook allows it, the best index for cut
//! blocks, one table or many, and equal output for any number of threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cvr_codec_tests::{bytes, hash, settings};
use cvr_core::codec::{
    Codec as _, DecodedForm, Decoder, EncodeError, Progress, TexelFormat, decode_frame, encode_file,
    encode_temporary,
};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::{FiniteVolume, FrameIndex, NoReferences, Replaced};
use cvr_vq::{Parameters, Vq};

fn encoded(volume: &FiniteVolume, pairs: &[(&str, &str)]) -> Arc<EncodedVolume> {
    Arc::new(encode_temporary(&Vq, &settings(pairs), volume).unwrap())
}

fn decoder(stream: &Arc<EncodedVolume>) -> Box<dyn Decoder> {
    Vq.decoder(Arc::clone(stream)).unwrap()
}

fn decoded(stream: &Arc<EncodedVolume>, frame: u32) -> Vec<f32> {
    decode_frame(decoder(stream).as_ref(), FrameIndex(frame), &NoReferences).unwrap()
}

fn tables(stream: &EncodedVolume) -> Vec<u32> {
    stream.parameters::<Parameters>().unwrap().tables
}

fn frame_values(volume: &FiniteVolume, frame: u32) -> Vec<f32> {
    volume.dense().frame_values(FrameIndex(frame))
}

#[test]
fn fewer_distinct_blocks_than_codewords_are_lossless() {
    // Six kinds of blocks, in a volume without cut blocks.
    let volume = bytes([24, 12, 8], 1, 1, |p, _, _| ((p[0] / 4 + p[1] / 4 + p[2] / 4) % 6 * 40) as u8);
    let stream = encoded(&volume, &[("block", "4")]);
    assert_eq!(tables(&stream), [6]);
    assert_eq!(stream.spec().report.error_bound, Some(0.0));
    assert_eq!(decoded(&stream, 0), frame_values(&volume, 0));
    assert!(
        stream.spec().report.notes[0].contains("6 codewords serve where 256"),
        "{:?}",
        stream.spec().report
    );
    // 12 × 3 × ... blocks of 3 bits each: nothing but the header is large.
    assert_eq!(
        stream.tensor("index", cvr_core::container::Element::U32).unwrap().words().len(),
        (36 * 3_usize).div_ceil(32)
    );
}

#[test]
fn one_voxel_and_a_constant_volume_are_lossless() {
    for volume in [bytes([1, 1, 1], 3, 1, |_, c, _| 7 * c as u8), bytes([9, 5, 3], 1, 2, |_, _, _| 200)] {
        let stream = encoded(&volume, &[]);
        assert_eq!(tables(&stream), [1]);
        assert_eq!(stream.spec().report.error_bound, Some(0.0));
        assert_eq!(decoded(&stream, 0), frame_values(&volume, 0));
    }
}

/// Values outside the volume must not affect the index: the codeword of a cut block is the best for its voxels.
#[test]
fn no_other_codeword_serves_a_cut_block_better() {
    let volume = bytes([9, 7, 5], 1, 1, |p, _, _| hash(p, 3));
    let stream = encoded(&volume, &[("block", "4"), ("codewords", "6")]);
    let parameters: Parameters = stream.parameters().unwrap();
    let codebook = stream.tensor("codebook", cvr_core::container::Element::U32).unwrap().bytes().to_vec();
    let shown = |k: usize, i: usize| parameters.offset + parameters.step * f32::from(codebook[k * 64 + i]);
    let (source, got) = (frame_values(&volume, 0), decoded(&stream, 0));
    let mut cut = 0;
    for block in 0..3 * 2 * 2_u32 {
        let b = [block % 3, block / 3 % 2, block / 6];
        let voxels: Vec<(usize, usize)> = (0..64_u32)
            .filter_map(|i| {
                let p = [b[0] * 4 + i % 4, b[1] * 4 + i / 4 % 4, b[2] * 4 + i / 16];
                let inside = p[0] < 9 && p[1] < 7 && p[2] < 5;
                inside.then_some((((p[2] * 7 + p[1]) * 9 + p[0]) as usize, i as usize))
            })
            .collect();
        cut += usize::from(voxels.len() < 64);
        let error = |shown: &dyn Fn(usize, usize) -> f32| -> f64 {
            voxels.iter().map(|(v, i)| f64::from(source[*v] - shown(*v, *i)).powi(2)).sum()
        };
        let own = error(&|v, _| got[v]);
        for k in 0..6 {
            assert!(own <= error(&|_, i| shown(k, i)), "block {b:?}: codeword {k} is nearer");
        }
    }
    assert!(cut > 6);
}

#[test]
fn frames_share_a_table_or_have_their_own() {
    let volume = bytes([16, 16, 16], 1, 3, |p, _, f| hash(p, f) / 4 + 60 * f as u8);
    let shared = encoded(&volume, &[("codewords", "32")]);
    let each = encoded(&volume, &[("codewords", "32"), ("tables", "per-frame")]);
    assert_eq!((tables(&shared), tables(&each)), (vec![32], vec![32, 32, 32]));
    let error = |stream: &Arc<EncodedVolume>, frame| -> f64 {
        let pairs = decoded(stream, frame).into_iter().zip(frame_values(&volume, frame));
        pairs.map(|(d, s)| f64::from(d - s).powi(2)).sum()
    };
    for frame in 0..3 {
        assert!(error(&each, frame) < error(&shared, frame), "frame {frame}");
    }
    // Tables of unequal size: the smaller one is padded.
    let volume = bytes([8, 8, 8], 1, 2, |p, _, f| if f == 0 { 9 } else { hash(p, 1) });
    let each = encoded(&volume, &[("tables", "per-frame")]);
    assert_eq!(tables(&each), [1, 64]);
    assert_eq!(decoded(&each, 0), frame_values(&volume, 0));
    assert_eq!(decoded(&each, 1), frame_values(&volume, 1));
}

#[test]
fn colours_are_coded_together() {
    let volume = bytes([8, 8, 8], 3, 1, |p, c, _| hash([p[0] / 2, p[1] / 2, p[2] / 2], c));
    let stream = encoded(&volume, &[]);
    assert_eq!(tables(&stream), [64], "64 blocks, each of one colour");
    assert_eq!(decoded(&stream, 0), frame_values(&volume, 0));
}

#[test]
fn any_number_of_threads_gives_the_same_file() {
    let volume = bytes([40, 33, 21], 1, 1, |p, _, _| hash(p, 9) / 8 + (p[0] * p[1] / 9) as u8);
    let folder = tempfile::tempdir().unwrap();
    let on = |threads: usize| {
        let path = folder.path().join(format!("{threads}.cvr"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let pairs = settings(&[("training_blocks", "3000"), ("codewords", "200")]);
        pool.install(|| {
            encode_file(&Vq, &pairs, &volume, Replaced::default(), &path, &Progress::silent()).unwrap();
        });
        std::fs::read(path).unwrap()
    };
    let one = on(1);
    assert!(one == on(2) && one == on(4), "the bytes depend on the number of threads");
}

#[test]
fn another_seed_draws_other_blocks() {
    let volume = bytes([32, 32, 32], 1, 1, |p, _, _| hash(p, 9));
    let with = |seed| encoded(&volume, &[("training_blocks", "64"), ("codewords", "16"), ("seed", seed)]);
    let codewords = |stream: &EncodedVolume| {
        stream.tensor("codebook", cvr_core::container::Element::U32).unwrap().bytes().to_vec()
    };
    assert_eq!(codewords(&with("1")), codewords(&with("1")));
    assert_ne!(codewords(&with("1")), codewords(&with("2")));
    assert_eq!(with("5").parameters::<Parameters>().unwrap().training.blocks, [64]);
}

#[test]
fn every_first_codebook_is_refined_and_recorded() {
    let volume = bytes([32, 32, 32], 1, 1, |p, _, _| hash(p, 9) / 4 + (p[0] * 5) as u8);
    let shown = |stream: &Arc<EncodedVolume>| decoded(stream, 0);
    let one = encoded(&volume, &[("codewords", "2"), ("iterations", "0")]);
    let source = frame_values(&volume, 0);
    let error = |stream: &Arc<EncodedVolume>| -> f64 {
        shown(stream).iter().zip(&source).map(|(d, s)| f64::from(d - s).powi(2)).sum()
    };
    let mut files = Vec::new();
    for init in ["pca", "pnn", "scalar", "random"] {
        let stream = encoded(&volume, &[("codewords", "64"), ("init", init)]);
        assert_eq!(stream.parameters::<Parameters>().unwrap().training.initial, init);
        assert!(error(&stream) < error(&one) / 2.0, "{init}");
        files.push(shown(&stream));
    }
    for (i, a) in files.iter().enumerate() {
        assert!(files[i + 1..].iter().all(|b| a != b), "two ways to begin are one");
    }
}

/// Every texel is a code: a texture holds what the CPU decodes.
#[test]
fn a_texel_is_a_code() {
    let volume = bytes([8, 8, 8], 1, 1, |p, _, _| hash(p, 9) / 2 + 20);
    let form = |bits| decoder(&encoded(&volume, &[("codeword_bits", bits)])).decoded_form();
    let DecodedForm { format, scale, offset } = form("8");
    assert_eq!(
        (format, offset),
        (TexelFormat::Unorm8, *frame_values(&volume, 0).iter().min_by(|a, b| a.total_cmp(b)).unwrap())
    );
    // A range of at most 127: two codes per grey level.
    assert_eq!(scale, 127.5);
    assert_eq!(form("16").format, TexelFormat::Unorm16);
}

#[test]
fn a_user_can_stop_the_training() {
    let volume = bytes([32, 32, 32], 1, 1, |p, _, _| hash(p, 9));
    let (flag, calls) = (AtomicBool::new(false), std::sync::atomic::AtomicU32::new(0));
    // Reading and training report no voxels, so the flag is set long before the first block is coded.
    let run = Progress::new(
        |voxels| {
            assert_eq!(voxels, 0, "coding began");
            flag.store(calls.fetch_add(1, Ordering::Relaxed) > 20, Ordering::Relaxed);
        },
        Some(&flag),
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.cvr");
    let stopped = encode_file(&Vq, &settings(&[]), &volume, Replaced::default(), &path, &run);
    assert!(matches!(stopped, Err(EncodeError::Cancelled)), "{stopped:?}");
    assert!(!path.exists());
}
