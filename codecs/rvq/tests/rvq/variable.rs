//! The payload `variable`: targets, escapes, bits of empty blocks.

use std::sync::Arc;

use cvr_codec_tests::{bytes, hash, settings};
use cvr_core::codec::{Codec as _, decode_frame, decode_stages, encode_temporary};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::{
    BrickSource as _, DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, SampleType, Samples,
    VolumeLayout,
};
use cvr_rvq::Rvq;

fn encoded(volume: &FiniteVolume, pairs: &[(&str, &str)]) -> Arc<EncodedVolume> {
    let all = [&[("payload", "variable")], pairs].concat();
    Arc::new(encode_temporary(&Rvq, &settings(&all), volume).unwrap())
}

/// Errors of all samples of a frame, integers rounded, from so many stages.
fn errors(stream: &Arc<EncodedVolume>, volume: &FiniteVolume, stages: u8) -> Vec<f64> {
    let decoder = Rvq.decoder(Arc::clone(stream)).unwrap();
    let integers = volume.layout().sample.is_integer();
    let mut all = Vec::new();
    for frame in (0..volume.layout().frames).map(FrameIndex) {
        let decoded = decode_stages(decoder.as_ref(), frame, stages, &NoReferences).unwrap();
        let source = volume.dense().frame_values(frame);
        let shown = |d: f32| f64::from(if integers { d.round() } else { d });
        all.extend(decoded.iter().zip(source).map(|(d, s)| shown(*d) - f64::from(s)));
    }
    all
}

fn square(errors: &[f64]) -> f64 {
    errors.iter().map(|e| e * e).sum()
}

fn psnr(stream: &Arc<EncodedVolume>, volume: &FiniteVolume) -> f64 {
    let errors = errors(stream, volume, u8::MAX);
    10.0 * (volume.range().span().powi(2) * errors.len() as f64 / square(&errors)).log10()
}

fn rate(stream: &EncodedVolume, volume: &FiniteVolume) -> f64 {
    8.0 * stream.file_bytes() as f64 / volume.layout().samples() as f64
}

/// A textured ball in empty space with a thin shell of noise, which codebooks never learn.
fn shell(size: [u32; 3], channels: u32) -> FiniteVolume {
    bytes(size, channels, 1, |p, c, _| {
        let q = [0, 1, 2].map(|a| f64::from(p[a]) / f64::from(size[a]) - 0.5);
        let r = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        match r {
            0.36..0.39 => hash(p, c),
            0.39.. => 0,
            _ => {
                (90.0 + 40.0 * q[0] + 30.0 * (9.0 * q[1] + f64::from(c)).sin() + 12.0 * (31.0 * q[2]).cos())
                    as u8
            }
        }
    })
}

#[test]
fn the_rate_is_met_or_the_file_is_lossless() {
    for (channels, rates) in [(1, ["1", "2.5", "6"]), (3, ["0.8", "2", "6"])] {
        let volume = shell([64, 56, 52], channels);
        for asked in rates {
            let stream = encoded(&volume, &[("rate", asked)]);
            let (found, most) = (rate(&stream, &volume), asked.parse::<f64>().unwrap());
            let lossless = psnr(&stream, &volume) == f64::INFINITY;
            assert!(found <= most && (lossless || found > 0.985 * most), "{channels} {asked}: {found}");
        }
    }
}

#[test]
fn every_psnr_is_reached_and_costs_more_where_it_is_higher() {
    let volume = shell([44, 40, 36], 1);
    let mut last = 0.0;
    for asked in [30.0, 45.0, 60.0, 100.0] {
        let stream = encoded(&volume, &[("psnr", &asked.to_string()), ("stages", "6")]);
        let (found, bits) = (psnr(&stream, &volume), rate(&stream, &volume));
        assert!(found >= asked && bits > last, "{asked}: {found} dB at {bits} bits after {last}");
        assert!(found < asked + 1.0 || asked == 100.0, "{found} dB for {asked}");
        last = bits;
    }
}

/// A bound holds for every sample of integers and of floats, whatever a codebook can do.
#[test]
fn no_sample_exceeds_a_bound() {
    for (channels, bound) in [(1, "3"), (1, "0.5"), (1, "20"), (3, "2")] {
        let volume = shell([36, 40, 24], channels);
        let stream = encoded(&volume, &[("max_error", bound), ("beam", "1")]);
        let worst = errors(&stream, &volume, u8::MAX).iter().fold(0.0_f64, |worst, e| worst.max(e.abs()));
        assert!(worst <= bound.parse().unwrap(), "{worst} for {bound}");
        assert_eq!(stream.spec().report.error_bound, Some(worst));
    }
    let layout = VolumeLayout::scalar(Extent::new(25, 22, 19).unwrap(), SampleType::F32);
    let value = |i: u64| (i as f32 * 0.01).sin() * 7.3 + f32::from(hash([i as u32, 0, 0], 3)) * 1e-2;
    let samples = Samples::F32((0..layout.samples()).map(value).collect());
    let volume = FiniteVolume::new(DenseVolume::new(layout, samples).unwrap());
    for bound in ["0.5", "0.01"] {
        let stream = encoded(&volume, &[("max_error", bound)]);
        let worst = errors(&stream, &volume, u8::MAX).iter().fold(0.0_f64, |worst, e| worst.max(e.abs()));
        assert!(worst <= bound.parse().unwrap(), "{worst} for {bound}");
    }
}

/// A tighter bound costs more bits, and one that the number of levels forbids is refused.
#[test]
fn a_bound_has_its_price_and_its_end() {
    let volume = shell([36, 40, 24], 1);
    let of = |bound| rate(&encoded(&volume, &[("max_error", bound), ("beam", "1")]), &volume);
    assert!(of("1") > of("4") && of("4") > of("16"));
    let layout = VolumeLayout::scalar(Extent::new(8, 8, 8).unwrap(), SampleType::F32);
    let samples = Samples::F32((0..512).map(|i| (i as f32).sin() * 1e4).collect());
    let volume = FiniteVolume::new(DenseVolume::new(layout, samples).unwrap());
    let pairs = settings(&[("payload", "variable"), ("max_error", "1e-3")]);
    let refused = encode_temporary(&Rvq, &pairs, &volume).unwrap_err().to_string();
    assert!(refused.contains("ask for a larger `max_error`"), "{refused}");
}

/// An empty block costs two bits at most, the heads of groups included.
#[test]
fn empty_blocks_cost_next_to_nothing() {
    let empty = |edge: u32| {
        let volume = bytes([edge; 3], 1, 1, |p, _, _| if p.iter().all(|p| *p < 16) { hash(p, 1) } else { 9 });
        let stream = encoded(&volume, &[("psnr", "50")]);
        8 * stream.file_bytes()
    };
    let (small, large) = (empty(32), empty(128));
    let blocks = u64::from((128_u32 / 4).pow(3) - (32_u32 / 4).pow(3));
    assert!(large - small <= 2 * blocks, "{} bits for {blocks} blocks", large - small);
}

/// Few blocks hold nearly all of the error: what is coded directly gains decibels over codes alone.
#[test]
fn blocks_that_codebooks_do_not_learn_are_coded_directly() {
    let volume = shell([64, 64, 64], 1);
    let stream = encoded(&volume, &[("rate", "2")]);
    let stages = stream.spec().parameters["tables"][0]["codewords"].as_array().unwrap().len() as u8;
    assert!(stages >= 2, "{stages} stages");
    let (part, all) = (errors(&stream, &volume, stages - 1), errors(&stream, &volume, stages));
    assert!(square(&all) < 0.2 * square(&part), "{} of {}", square(&all), square(&part));
}

/// Waves that bend: blocks that are alike, and none twice.
fn waves(channels: u32) -> FiniteVolume {
    bytes([64, 64, 64], channels, 1, |p, c, _| {
        let [x, y, z] = p.map(f64::from);
        let first = (0.31 * x + 0.9 * (0.2 * y).sin() + f64::from(c)).sin();
        (120.0 + 60.0 * first + 40.0 * (0.43 * y + 0.37 * z).cos()) as u8 + hash(p, c) / 64
    })
}

#[test]
fn no_stage_raises_the_error() {
    for (channels, rate) in [(1, "0.8"), (3, "0.5")] {
        let volume = waves(channels);
        let stream = encoded(&volume, &[("rate", rate), ("stages", "5"), ("codewords", "32")]);
        let of: Vec<f64> = (1..=5).map(|stages| square(&errors(&stream, &volume, stages))).collect();
        assert!(of.is_sorted_by(|a, b| a >= b) && of[4] < of[0], "{of:?}");
    }
}

#[test]
fn beam_and_refinement_lower_the_error() {
    let volume = waves(1);
    let with = |beam, refinement| {
        let pairs = [("rate", "0.8"), ("codewords", "32"), ("beam", beam), ("refinement", refinement)];
        square(&errors(&encoded(&volume, &pairs), &volume, u8::MAX))
    };
    let (greedy, both) = (with("1", "0"), with("8", "4"));
    assert!(both < greedy, "{both} of {greedy}");
}

#[test]
fn any_number_of_threads_gives_the_same_values() {
    let volume = shell([40, 33, 21], 1);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let stream = pool.install(|| encoded(&volume, &[("rate", "1"), ("training_blocks", "300")]));
        let words = stream.tensor("index", cvr_core::container::Element::U32).unwrap().words().to_vec();
        let decoder = Rvq.decoder(stream).unwrap();
        (words, decode_frame(decoder.as_ref(), FrameIndex::FIRST, &NoReferences).unwrap())
    };
    let one = on(1);
    assert!(one == on(2) && one == on(4), "the stream depends on the number of threads");
}

/// Targets belong to the payload that has them, one at a time.
#[test]
fn contradictions_are_refused() {
    let of = |pairs: &[(&str, &str)]| {
        let volume = bytes([8, 8, 8], 1, 1, hash_of);
        encode_temporary(&Rvq, &settings(pairs), &volume).unwrap_err().to_string()
    };
    assert!(of(&[("rate", "1")]).contains("`rate` of rvq needs `payload = \"variable\"`"));
    let two = of(&[("payload", "variable"), ("rate", "1"), ("psnr", "40")]);
    assert!(two.contains("`rate` and `psnr` of rvq are two targets"), "{two}");
}

fn hash_of(p: [u32; 3], c: u32, _: u32) -> u8 {
    hash(p, c)
}
