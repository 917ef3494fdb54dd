//! Properties of the encoder beyond the conformance tests: targets, levels, sub-volumes, classes.

use std::sync::Arc;

use cvr_codec_tests::kept::with_flipped;
use cvr_codec_tests::settings;
use cvr_core::codec::{Codec as _, Decoder, decode_frame, decode_stages, encode_temporary};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::{
    BrickSource as _, DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, SampleType, Samples,
    VolumeLayout,
};
use cvr_tvq::Tvq;

fn encoded(volume: &FiniteVolume, pairs: &[(&str, &str)]) -> Arc<EncodedVolume> {
    Arc::new(encode_temporary(&Tvq, &settings(pairs), volume).unwrap())
}

fn decoder(stream: &Arc<EncodedVolume>) -> Box<dyn Decoder> {
    Tvq.decoder(Arc::clone(stream)).unwrap()
}

fn volume(
    size: [u32; 3],
    channels: u32,
    frames: u32,
    value: impl Fn([f64; 3], u32, u32) -> f64,
) -> FiniteVolume {
    let extent = Extent::try_from(size).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, SampleType::U8) };
    let sample = |i: u64| {
        let (voxel, channel) = (i / u64::from(channels), (i % u64::from(channels)) as u32);
        let (frame, voxel) = ((voxel / extent.voxels()) as u32, (voxel % extent.voxels()) as usize);
        value(extent.position(voxel).map(f64::from), channel, frame).round().clamp(0.0, 255.0) as u8
    };
    let samples = Samples::U8((0..layout.samples()).map(sample).collect());
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

/// A hollow ball with ripples on one side: flat, smooth and detailed blocks.
fn ball(size: [u32; 3]) -> FiniteVolume {
    volume(size, 1, 1, |p, _, _| {
        let q = [0, 1, 2].map(|a| p[a] / f64::from(size[a]) - 0.5);
        let r = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        let ripple = if q[0] > 0.0 { 20.0 * (p[0] * 1.7).sin() * (p[1] * 1.3).cos() } else { 0.0 };
        if (0.25..0.45).contains(&r) { 150.0 + 200.0 * (r - 0.25) + ripple } else { 20.0 }
    })
}

fn errors(stream: &Arc<EncodedVolume>, volume: &FiniteVolume, stages: u8) -> Vec<f64> {
    let decoder = decoder(stream);
    let decoded = decode_stages(decoder.as_ref(), FrameIndex::FIRST, stages, &NoReferences).unwrap();
    let source = volume.dense().frame_values(FrameIndex::FIRST);
    decoded.iter().zip(source).map(|(d, s)| f64::from(d.round()) - f64::from(s)).collect()
}

fn psnr(stream: &Arc<EncodedVolume>, volume: &FiniteVolume) -> f64 {
    let errors = errors(stream, volume, u8::MAX);
    let square: f64 = errors.iter().map(|e| e * e).sum();
    10.0 * (volume.range().span().powi(2) * errors.len() as f64 / square).log10()
}

fn rate(stream: &EncodedVolume, volume: &FiniteVolume) -> f64 {
    8.0 * stream.file_bytes() as f64 / volume.layout().samples() as f64
}

#[test]
fn a_fixed_file_is_within_the_rate_and_near_it() {
    let ball = ball([64, 60, 52]);
    for target in ["0.8", "1.5"] {
        let stream = encoded(&ball, &[("rate", target)]);
        let (found, asked) = (rate(&stream, &ball), target.parse::<f64>().unwrap());
        assert!(found <= asked && found > 0.75 * asked, "{target}: {found}");
    }
}

#[test]
fn a_psnr_is_reached_and_costs_more_where_it_is_higher() {
    let ball = ball([48, 52, 40]);
    for payload in ["fixed", "variable"] {
        let of = |target: &str| {
            let stream = encoded(&ball, &[("payload", payload), ("psnr", target)]);
            let found = psnr(&stream, &ball);
            assert!(found >= target.parse::<f64>().unwrap(), "{payload}: {found} for {target}");
            // Widths of codes are whole numbers, and there are few blocks.
            let slack = if payload == "fixed" { 4.0 } else { 0.5 };
            assert!(found <= target.parse::<f64>().unwrap() + slack, "{payload}: {found} for {target}");
            rate(&stream, &ball)
        };
        assert!(of("28") < of("33"), "{payload}");
    }
}

/// A smooth volume with a thin shell of noise, which codebooks never learn.
fn shell(size: [u32; 3]) -> FiniteVolume {
    volume(size, 1, 1, |p, _, _| {
        let q = [0, 1, 2].map(|a| p[a] / f64::from(size[a]) - 0.5);
        let r = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        let hash = (p[0] + 131.0 * p[1] + 17161.0 * p[2]) as u32;
        let noise = f64::from(hash.wrapping_mul(0x9e37_79b9) >> 24);
        if (0.38..0.41).contains(&r) { noise } else { 60.0 + 40.0 * q[0] + 30.0 * (9.0 * q[1]).sin() }
    })
}

fn escaped(stream: &EncodedVolume) -> u64 {
    stream.spec().parameters["training"]["payload"]["blocks_escaped"].as_u64().unwrap()
}

/// What codebooks cannot reach, escapes do: up to every voxel as it was.
#[test]
fn every_psnr_is_reached() {
    let shell = shell([44, 40, 36]);
    for target in [45.0, 60.0, 100.0] {
        let stream =
            encoded(&shell, &[("payload", "variable"), ("psnr", &target.to_string()), ("codes", "4")]);
        let found = psnr(&stream, &shell);
        assert!(found >= target, "{found} dB for {target}");
        assert!(escaped(&stream) > 0 && stream.spec().report.notes.is_empty(), "{target} dB");
    }
}

/// The rate is used to 1 %, or nothing is lost.
#[test]
fn the_rate_is_met_or_the_file_is_lossless() {
    for (name, volume, targets) in [
        ("ball", ball([64, 60, 52]), [0.8, 3.0]),
        ("shell", shell([44, 40, 36]), [2.0, 6.0]),
        ("shell", shell([20, 24, 20]), [4.0, 12.0]),
    ] {
        for target in targets {
            let stream = encoded(&volume, &[("payload", "variable"), ("rate", &target.to_string())]);
            let (rate, psnr) = (rate(&stream, &volume), psnr(&stream, &volume));
            let lossless = psnr == f64::INFINITY;
            assert!(
                rate <= target && (lossless || rate > 0.99 * target),
                "{name}: {rate} of {target}, {psnr} dB"
            );
        }
    }
}

/// Few blocks hold nearly all of the error. At the same rate, what is coded directly gains decibels over codes alone.
#[test]
fn blocks_that_codebooks_do_not_learn_are_coded_directly() {
    let shell = shell([64, 64, 64]);
    let stream = encoded(&shell, &[("payload", "variable"), ("rate", "1.5")]);
    let blocks = 16_u64.pow(3);
    assert!((1..blocks / 2).contains(&escaped(&stream)), "{} of {blocks}", escaped(&stream));
    let errors = errors(&stream, &shell, 3);
    let all = self::errors(&stream, &shell, 4);
    let square = |errors: &[f64]| errors.iter().map(|e| e * e).sum::<f64>();
    assert!(square(&all) < 0.1 * square(&errors), "{} of {}", square(&all), square(&errors));
}

#[test]
fn both_targets_are_met_or_the_rate_alone() {
    let ball = ball([48, 48, 40]);
    let within = |rate_: &str, psnr_: &str| {
        let stream = encoded(&ball, &[("payload", "variable"), ("rate", rate_), ("psnr", psnr_)]);
        (rate(&stream, &ball), psnr(&stream, &ball))
    };
    let (rate, found) = within("8", "35");
    assert!(rate < 6.0 && (35.0..36.0).contains(&found), "{rate} bits, {found} dB");
    let (rate, found) = within("0.9", "60");
    assert!(rate <= 0.9 && found < 60.0, "{rate} bits, {found} dB");
}

/// A target that cannot be reached gives a note.
#[test]
fn a_target_out_of_reach_is_told() {
    let ball = ball([16, 16, 12]);
    for (payload, name, value) in
        [("fixed", "rate", "0.01"), ("variable", "rate", "0.01"), ("fixed", "psnr", "90")]
    {
        let stream = encoded(&ball, &[("payload", payload), (name, value), ("index_bits", "4")]);
        assert!(!stream.spec().report.notes.is_empty(), "{payload} {name}");
    }
}

#[test]
fn every_level_adds_and_none_harms() {
    let ball = ball([40, 44, 36]);
    for pairs in [
        [("payload", "fixed"), ("codevectors", "partition")],
        [("payload", "fixed"), ("codevectors", "joint")],
        [("payload", "variable"), ("rate", "2")],
    ] {
        let stream = encoded(&ball, &pairs);
        let square = |stages| errors(&stream, &ball, stages).iter().map(|e| e * e).sum::<f64>();
        let levels = [1, 2, 3, 4].map(square);
        assert!(levels.is_sorted_by(|a, b| a >= b) && levels[3] < 0.5 * levels[0], "{pairs:?}: {levels:?}");
    }
}

/// A seam would show as larger errors in the voxels beside it.
#[test]
fn sub_volumes_have_tables_of_their_own_and_no_seams() {
    let ball = ball([148, 40, 36]);
    for payload in ["fixed", "variable"] {
        let stream = encoded(&ball, &[("payload", payload), ("subvolume", "128"), ("rate", "1")]);
        assert_eq!(stream.spec().tensors["tables"].shape[..2], [1, 2]);
        let errors = errors(&stream, &ball, u8::MAX);
        let of = |slices: std::ops::Range<usize>| {
            let all = errors.iter().enumerate().filter(|(i, _)| slices.contains(&(i % 148)));
            let (sum, count) = all.fold((0.0, 0.0), |(s, n), (_, e)| (s + e * e, n + 1.0));
            sum / count
        };
        let (beside, around) = (of(127..129), of(120..136));
        assert!(beside <= 2.0 * around + 0.1, "{payload}: {beside} beside the seam, {around} around it");
    }
}

/// Indices are reordered block by block after they were checked. This must not mix sub-volumes.
#[test]
fn sub_volumes_whose_indices_do_not_follow_each_other_are_refused() {
    let stream = encoded(&ball([148, 40, 36]), &[("subvolume", "128")]);
    // The lowest bit of a table's word 3: the start of its indices.
    let table_bytes = 4 * (5 + 3 * 3);
    for (table, begin) in [(0, "[0, 0, 0] begin at word 1 of"), (1, "[1, 0, 0] begin at word")] {
        let changed = with_flipped(&Tvq, &stream, "tables", table * table_bytes + 12);
        let problem = Tvq.decoder(Arc::new(changed)).unwrap_err().to_string();
        assert!(problem.contains("frame 0: the indices of sub-volume"), "{problem}");
        assert!(problem.contains(begin), "{problem}");
    }
}

#[test]
fn colours_and_frames_share_or_own_their_codebooks() {
    let wave = volume([20, 16, 13], 3, 2, |p, c, f| {
        128.0 + 60.0 * ((p[0] + f64::from(f) * 3.0) * 0.4 + f64::from(c)).sin() + 30.0 * (p[1] * 0.9).cos()
    });
    let check = |tables: &str, payload: &str| {
        let rate = if payload == "fixed" { "0" } else { "10" };
        let pairs = [("tables", tables), ("payload", payload), ("index_bits", "5"), ("rate", rate)];
        let stream = encoded(&wave, &pairs);
        let sets = if tables == "shared" { 1 } else { 2 };
        assert_eq!(stream.spec().tensors["tables"].shape[0], sets);
        let decoder = decoder(&stream);
        for frame in [0, 1].map(FrameIndex) {
            let decoded = decode_frame(decoder.as_ref(), frame, &NoReferences).unwrap();
            let source = wave.dense().frame_values(frame);
            let square: f64 = decoded.iter().zip(&source).map(|(d, s)| f64::from(d - s).powi(2)).sum::<f64>();
            assert!(square / (source.len() as f64) < 150.0, "{tables} {payload}: {square}");
        }
    };
    for payload in ["fixed", "variable"] {
        check("shared", payload);
        check("per-frame", payload);
    }
}

/// Fewer kinds of blocks than codewords: coding is lossless, and codes take no more bits than the kinds need.
#[test]
fn few_kinds_of_blocks_are_lossless() {
    let checks = volume([32, 32, 32], 1, 1, |p, _, _| {
        let kind = (p[0] / 4.0).floor() + 3.0 * (p[1] / 4.0).floor();
        if kind % 3.0 == 0.0 { 40.0 } else { 40.0 + 10.0 * (p[2] % 4.0) * (kind % 3.0) }
    });
    let stream = encoded(&checks, &[]);
    assert!(errors(&stream, &checks, u8::MAX).iter().all(|e| *e == 0.0));
    let constant = volume([9, 5, 6], 1, 1, |_, _, _| 77.0);
    for payload in ["fixed", "variable"] {
        let stream = encoded(&constant, &[("payload", payload)]);
        assert!(errors(&stream, &constant, u8::MAX).iter().all(|e| *e == 0.0), "{payload}");
    }
}

/// Every transform, confined to its zones, is better than means alone. A class threshold above all errors leaves only
/// means.
#[test]
fn transforms_and_thresholds_matter_where_codevectors_are_confined() {
    let ball = ball([32, 36, 28]);
    let square = |pairs: &[(&str, &str)], stages| {
        let pairs = [&[("codevectors", "partition"), ("index_bits", "6")], pairs].concat();
        errors(&encoded(&ball, &pairs), &ball, stages).iter().map(|e| e * e).sum::<f64>()
    };
    let means = square(&[], 1);
    for transform in ["klt", "dct", "wht", "haar", "klt-full"] {
        let all = square(&[("transform", transform)], 4);
        assert!(all < 0.5 * means, "{transform}: {all} of {means}");
    }
    let (with, without) =
        (square(&[("classification", "true")], 4), square(&[("classification", "false")], 4));
    assert!(with < 0.5 * means && without < 0.5 * means && with != without);
}

/// There are just enough blocks. With one layer of them less, sizes follow the number of blocks.
#[test]
fn without_a_target_fixed_has_three_codes_of_eight_bits() {
    let widths = |extent: [u32; 3]| {
        let stream = encoded(&ball(extent), &[("training_blocks", "2048"), ("iterations", "1")]);
        stream.spec().parameters["training"]["payload"]["widths"].clone()
    };
    assert_eq!(widths([132, 128, 128]), serde_json::json!([8, 8, 8]));
    assert_ne!(widths([128, 128, 128]), serde_json::json!([8, 8, 8]));
}
