//! Properties of the encoder beyond the conformance tests: lossless if the codebooks allow it, the contribution of each
//! stage, the best index for cut blocks, one pair of tables or many, and equal output for any number of threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cvr_codec_tests::{bytes, hash, settings};
use cvr_core::codec::{
    Codec as _, DecodedForm, Decoder, EncodeError, Progress, TexelFormat, decode_stages, encode_file,
    encode_temporary,
};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::{
    DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, Replaced, SampleType, Samples, VolumeLayout,
};
use cvr_hvq::{Hvq, Parameters};

fn encoded(volume: &FiniteVolume, pairs: &[(&str, &str)]) -> Arc<EncodedVolume> {
    Arc::new(encode_temporary(&Hvq, &settings(pairs), volume).unwrap())
}

fn decoder(stream: &Arc<EncodedVolume>) -> Box<dyn Decoder> {
    Hvq.decoder(Arc::clone(stream)).unwrap()
}

fn decoded_from(stream: &Arc<EncodedVolume>, frame: u32, stages: u8) -> Vec<f32> {
    decode_stages(decoder(stream).as_ref(), FrameIndex(frame), stages, &NoReferences).unwrap()
}

fn decoded(stream: &Arc<EncodedVolume>, frame: u32) -> Vec<f32> {
    decoded_from(stream, frame, 3)
}

/// Codewords of the coarse and of the detail tables.
fn tables(stream: &EncodedVolume) -> [Vec<u32>; 2] {
    let Parameters { coarse, detail, .. } = stream.parameters().unwrap();
    [coarse.tables, detail.tables]
}

fn squared_error(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum()
}

fn frame_values(volume: &FiniteVolume, frame: u32) -> Vec<f32> {
    volume.dense().frame_values(FrameIndex(frame))
}

#[test]
fn fewer_distinct_blocks_than_codewords_are_lossless() {
    // Six kinds of constant blocks, in a volume without cut blocks.
    let volume = bytes([24, 12, 8], 1, 1, |p, _, _| ((p[0] / 4 + p[1] / 4 + p[2] / 4) % 6 * 40) as u8);
    let stream = encoded(&volume, &[]);
    assert_eq!(tables(&stream), [[1], [1]]);
    assert_eq!(stream.spec().report.error_bound, Some(0.0));
    assert!(decoded_from(&stream, 0, 1) == frame_values(&volume, 0), "means suffice");
    let notes = &stream.spec().report.notes;
    assert!(notes[0].contains("1 coarse codewords serve where 256"), "{notes:?}");
    assert!(notes[1].contains("1 detail codewords serve where 256"), "{notes:?}");
    // Seven kinds of noise.
    let volume = bytes([28, 8, 8], 1, 1, |p, _, _| hash([p[0], p[1] % 4, p[2] % 4], 5) / 2);
    let stream = encoded(&volume, &[]);
    assert!(decoded(&stream, 0) == frame_values(&volume, 0));
    assert!(tables(&stream).iter().all(|sizes| (7..=8).contains(&sizes[0])), "{:?}", tables(&stream));
}

#[test]
fn one_voxel_and_a_constant_volume_are_lossless() {
    for volume in [bytes([1, 1, 1], 3, 1, |_, c, _| 7 * c as u8), bytes([9, 5, 3], 1, 2, |_, _, _| 200)] {
        let stream = encoded(&volume, &[]);
        assert_eq!(tables(&stream), [[1], [1]]);
        assert_eq!(stream.spec().report.error_bound, Some(0.0));
        assert!(decoded(&stream, 0) == frame_values(&volume, 0));
    }
}

/// Each stage decodes to what the paper defines.
#[test]
fn a_stage_is_the_mean_of_what_the_next_decodes_to() {
    // Constant cubes of 2³: the means of sub-blocks describe them completely.
    let volume = bytes([16, 16, 16], 1, 1, |p, _, _| hash(p.map(|p| p / 2), 3) / 2 + 10);
    let stream = encoded(&volume, &[]);
    let source = frame_values(&volume, 0);
    assert!(decoded_from(&stream, 0, 2) == source, "64 blocks, and room for all in the coarse table");
    let means = decoded_from(&stream, 0, 1);
    let at = |values: &[f32], p: [usize; 3]| values[(p[2] * 16 + p[1]) * 16 + p[0]];
    for block in 0..64_usize {
        let first = [block % 4 * 4, block / 4 % 4 * 4, block / 16 * 4];
        let voxels = (0..64_usize).map(|i| [0, 1, 2].map(|a| first[a] + (i >> (2 * a) & 3)));
        let mean = voxels.clone().map(|p| at(&source, p)).sum::<f32>() / 64.0;
        for p in voxels {
            assert!((at(&means, p) - mean).abs() <= 0.5, "{p:?}: {} for {mean}", at(&means, p));
        }
    }
}

#[test]
fn every_block_gains_by_every_stage() {
    let volume = bytes([19, 13, 9], 3, 2, |p, c, f| hash(p, c + 3 * f) / 3 + (p[0] * 8) as u8);
    // One training block: the codewords suit few blocks.
    for pairs in [&[("training_blocks", "1")][..], &[("coarse_codewords", "9"), ("detail_codewords", "9")]] {
        let stream = encoded(&volume, pairs);
        for frame in 0..2 {
            let source = frame_values(&volume, frame);
            let levels = [1, 2, 3].map(|stages| decoded_from(&stream, frame, stages));
            let blocks = (0..5 * 4 * 3_usize).map(|b| [b % 5, b / 5 % 4, b / 20]);
            for block in blocks {
                let values = |of: &[f32]| -> Vec<f32> {
                    let inside = |(i, _): &(usize, &f32)| {
                        let voxel = i / 3;
                        [voxel % 19 / 4, voxel / 19 % 13 / 4, voxel / 19 / 13 / 4] == block
                    };
                    of.iter().enumerate().filter(inside).map(|(_, v)| *v).collect()
                };
                let errors = levels.each_ref().map(|l| squared_error(&values(l), &values(&source)));
                assert!(errors.is_sorted_by(|a, b| a >= b), "{pairs:?}, block {block:?}: {errors:?}");
            }
        }
    }
}

/// Values outside the volume must not affect the index: the codeword of a cut block is the best for its voxels.
#[test]
fn no_other_codeword_serves_a_cut_block_better() {
    let volume = bytes([9, 7, 5], 1, 1, |p, _, _| hash(p, 3) / 4 + 90);
    let stream = encoded(&volume, &[("coarse_codewords", "6"), ("detail_codewords", "6")]);
    let parameters: Parameters = stream.parameters().unwrap();
    let bytes = stream.tensor("codebook", cvr_core::container::Element::U32).unwrap().bytes().to_vec();
    let source = frame_values(&volume, 0);
    let levels = [1, 2, 3].map(|stages| decoded_from(&stream, 0, stages));
    let step = parameters.step;
    let added = |stage: &cvr_hvq::StageParameters, code: u8| {
        (f32::from(code) - stage.zero as f32) * stage.step as f32 * step
    };
    let first_detail = (parameters.coarse.tables[0] * 8) as usize;
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
        let sub = |i: usize| (i / 32) * 4 + (i / 8 % 2) * 2 + i / 2 % 2;
        for k in 0..6 {
            let coarse = |v: usize, i: usize| levels[0][v] + added(&parameters.coarse, bytes[k * 8 + sub(i)]);
            assert!(
                error(&|v, _| levels[1][v]) <= error(&coarse) + 1e-6,
                "block {b:?}: coarse {k} is nearer"
            );
            let detail = |v: usize, i: usize| {
                levels[1][v] + added(&parameters.detail, bytes[first_detail + k * 64 + i])
            };
            assert!(
                error(&|v, _| levels[2][v]) <= error(&detail) + 1e-6,
                "block {b:?}: detail {k} is nearer"
            );
        }
    }
    assert!(cut > 6);
}

#[test]
fn frames_share_tables_or_have_their_own() {
    let volume = bytes([16, 16, 16], 1, 3, |p, _, f| hash(p, f) / 4 + 60 * f as u8);
    let pairs = [("coarse_codewords", "16"), ("detail_codewords", "32")];
    let shared = encoded(&volume, &pairs);
    let each = encoded(&volume, &[&pairs[..], &[("tables", "per-frame")]].concat());
    assert_eq!((tables(&shared)[1].len(), tables(&each)[1].len()), (1, 3));
    let error = |stream: &Arc<EncodedVolume>, frame| {
        squared_error(&decoded(stream, frame), &frame_values(&volume, frame))
    };
    for frame in 0..3 {
        assert!(error(&each, frame) < error(&shared, frame), "frame {frame}");
    }
    // Tables of unequal size: the smaller one is padded.
    let volume = bytes([8, 8, 8], 1, 2, |p, _, f| if f == 0 { 9 } else { hash(p, 1) / 2 });
    let each = encoded(&volume, &[("tables", "per-frame")]);
    assert_eq!(tables(&each)[1][0], 1);
    assert!(tables(&each)[1][1] >= 8);
    assert!(decoded(&each, 0) == frame_values(&volume, 0));
    assert!(decoded(&each, 1) == frame_values(&volume, 1));
}

/// Training of a frame similar to the one before starts from that codebook, and needs no more rounds.
#[test]
fn the_codebook_of_a_frame_begins_with_that_of_the_frame_before() {
    let volume = bytes([32, 32, 32], 1, 2, |p, _, _| hash(p, 7) / 16 + (p[0] * p[1] / 6 + p[2] * 2) as u8);
    let pairs =
        [("coarse_codewords", "32"), ("detail_codewords", "32"), ("tables", "per-frame"), ("init", "random")];
    let stream = encoded(&volume, &pairs);
    let training = stream.parameters::<Parameters>().unwrap().training;
    for rounds in [training.coarse.rounds, training.detail.rounds] {
        assert!(rounds[1] < rounds[0], "{rounds:?}");
    }
}

#[test]
fn colours_are_coded_together() {
    let volume = bytes([16, 8, 8], 3, 1, |p, c, _| hash(p.map(|p| p / 2), c) / 2);
    let stream = encoded(&volume, &[]);
    assert!((16..=17).contains(&tables(&stream)[0][0]), "16 blocks: {:?}", tables(&stream));
    assert!(decoded_from(&stream, 0, 2) == frame_values(&volume, 0));
}

#[test]
fn means_are_as_deep_as_they_are_asked_for() {
    let extent = Extent::cube(16).unwrap();
    let values = (0..extent.voxels()).map(|i| (i as u32).wrapping_mul(0x9e37_79b9) as u16 >> 4);
    let layout = VolumeLayout::scalar(extent, SampleType::U16);
    let volume = FiniteVolume::new(DenseVolume::new(layout, Samples::U16(values.collect())).unwrap());
    let bits = |pairs: &[(&str, &str)]| encoded(&volume, pairs).parameters::<Parameters>().unwrap().mean_bits;
    assert_eq!([bits(&[]), bits(&[("mean_bits", "8")]), bits(&[("mean_bits", "16")])], [16, 8, 16]);
    let shallow = bytes([4, 4, 4], 1, 1, |p, _, _| hash(p, 1));
    assert_eq!(encoded(&shallow, &[]).parameters::<Parameters>().unwrap().mean_bits, 8);
}

#[test]
fn any_number_of_threads_gives_the_same_file() {
    let volume = bytes([40, 33, 21], 1, 1, |p, _, _| hash(p, 9) / 8 + (p[0] * p[1] / 9) as u8);
    let folder = tempfile::tempdir().unwrap();
    let on = |threads: usize| {
        let path = folder.path().join(format!("{threads}.cvr"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let pairs = settings(&[("training_blocks", "500"), ("detail_codewords", "200")]);
        pool.install(|| {
            encode_file(&Hvq, &pairs, &volume, Replaced::default(), &path, &Progress::silent()).unwrap();
        });
        std::fs::read(path).unwrap()
    };
    let one = on(1);
    assert!(one == on(2) && one == on(4), "the bytes depend on the number of threads");
}

#[test]
fn another_seed_draws_other_blocks() {
    let volume = bytes([32, 32, 32], 1, 1, |p, _, _| hash(p, 9));
    let with =
        |seed| encoded(&volume, &[("training_blocks", "64"), ("detail_codewords", "16"), ("seed", seed)]);
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
    let source = frame_values(&volume, 0);
    let sizes = [("coarse_codewords", "16"), ("detail_codewords", "16")];
    for init in cvr_codebook::Initial::NAMES {
        let of = |iterations| {
            let more = [("init", *init), ("iterations", iterations)];
            encoded(&volume, &[&sizes[..], &more].concat())
        };
        let (first, refined) = (of("0"), of("50"));
        assert_eq!(refined.parameters::<Parameters>().unwrap().training.initial, *init);
        let error = |stream| squared_error(&decoded(stream, 0), &source);
        assert!(error(&refined) < error(&first), "{init}");
    }
}

/// Every texel is a level: a texture holds what the CPU decodes.
#[test]
fn a_texel_is_a_level() {
    let volume = bytes([8, 8, 8], 1, 1, |p, _, _| hash(p, 9) / 2 + 20);
    let form = |bits| decoder(&encoded(&volume, &[("codeword_bits", bits)])).decoded_form();
    let DecodedForm { format, scale, offset } = form("8");
    let lowest = frame_values(&volume, 0).into_iter().fold(f32::MAX, f32::min);
    assert_eq!((format, offset), (TexelFormat::Unorm8, lowest));
    // A range of at most 127: one level per grey level, so that differences have their own codes.
    assert_eq!(scale, 255.0);
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
    let stopped = encode_file(&Hvq, &settings(&[]), &volume, Replaced::default(), &path, &run);
    assert!(matches!(stopped, Err(EncodeError::Cancelled)), "{stopped:?}");
    assert!(!path.exists());
}
