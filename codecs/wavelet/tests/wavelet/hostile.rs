//! Streams of whole volumes that no encoder wrote are refused, or decode to other voxels. No length in a stream makes a
//! decoder ask for memory that the volume does not need.

use std::process::Command;
use std::sync::Arc;

use cvr_codec_tests::{bytes, hash, settings};
use cvr_core::codec::{Codec as _, DecodeError, DecodedFrame, encode_temporary};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::{FiniteVolume, FrameIndex, Level};
use cvr_wavelet::Wavelet;
use cvr_wavelet::coders::Coding;
use cvr_wavelet::stream::pyramid::Pyramid;
use serde_json::json;

use super::whole::{CODERS, Content};

/// Numbers that look random (SplitMix64).
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ bits >> 31
    }

    fn below(&mut self, n: usize) -> usize {
        (self.roll() % n.max(1) as u64) as usize
    }
}

/// One to four edits of bytes. Half of them are of the first bytes, where headers and counts lie.
fn edit(dice: &mut Dice, bytes: &mut Vec<u8>) {
    for _ in 0..=dice.below(4) {
        let reach = if dice.below(2) == 0 { bytes.len().min(12) } else { bytes.len() };
        let at = dice.below(reach);
        let end = bytes.len().min(at + 1 + dice.below(8));
        match dice.below(8) {
            _ if bytes.is_empty() => bytes.extend((0..dice.below(40)).map(|_| dice.roll() as u8)),
            0 | 1 => bytes[at] ^= 1 << dice.below(8),
            2 => bytes[at..end].fill([0, 0x7f, 0x80, 0xff][dice.below(4)]),
            3 => bytes[at..].iter_mut().for_each(|byte| *byte = dice.roll() as u8),
            4 => bytes.iter_mut().for_each(|byte| *byte = dice.roll() as u8),
            5 => bytes.truncate(at),
            6 => drop(bytes.drain(at..end)),
            _ => bytes.extend((0..1 + dice.below(40)).map(|_| dice.roll() as u8)),
        }
    }
}

/// Coefficients of a band fall off, and a few are large.
fn coefficients(dice: &mut Dice, pyramid: &Pyramid) -> Vec<i32> {
    let count = pyramid.coefficients(pyramid.levels());
    let value = |_| match dice.below(12) {
        0 => dice.roll() as i32 >> (8 + dice.below(24)),
        1..4 => dice.below(9) as i32 - 4,
        _ => 0,
    };
    (0..count).map(value).collect()
}

/// Number of cases of each coder.
const CASES: usize = 2000;

/// The coders alone, over shapes of all kinds.
#[test]
fn no_chunk_makes_a_coder_panic() {
    for (coder, order) in CODERS {
        let coding = Coding::from_names(coder, order).unwrap().coder();
        let (mut dice, mut refused, mut same) = (Dice(1), 0, 0);
        for case in 0..CASES {
            let extent = [1 + dice.below(24), 1 + dice.below(17), 1 + dice.below(9)];
            let pyramid = Pyramid::new(extent, dice.below(5), dice.below(2) == 0);
            let right = coefficients(&mut dice, &pyramid);
            let mut chunks = coding.encode(&pyramid, &right);
            for _ in 0..=dice.below(2) {
                let chunk = dice.below(chunks.len());
                edit(&mut dice, &mut chunks[chunk]);
            }
            let chunks: Vec<&[u8]> = chunks.iter().map(Vec::as_slice).collect();
            for levels in [pyramid.levels(), pyramid.levels() / 2] {
                let mut out = vec![0; pyramid.coefficients(levels)];
                match coding.decode(&pyramid, levels, &chunks, &mut out) {
                    Ok(()) => same += usize::from(out == right),
                    Err(DecodeError::Corrupt(_)) => refused += 1,
                    Err(other) => panic!("{coder} {order}, case {case}: {other}"),
                }
            }
        }
        assert!(refused > CASES / 20, "{coder} {order}: {refused} of {CASES} refused");
        assert!(same < CASES / 2, "{coder} {order}: {same} of {CASES} are what they were");
    }
}

/// Odd sizes, colours and frames.
fn volume(channels: u32, frames: u32) -> FiniteVolume {
    bytes([20, 17, 9], channels, frames, |p, c, f| hash(p, c + f) / 8 + (p[0] * p[1] / 2 + p[2]) as u8)
}

/// Decodes all frames at all resolutions. Whether that succeeds.
fn survives(stream: Arc<EncodedVolume>) -> bool {
    let settings = stream.spec().settings.clone();
    let Ok(decoder) = Wavelet.decoder(stream) else { return false };
    let mut decodes = true;
    for frame in (0..decoder.layout().frames).map(FrameIndex) {
        for resolution in 0..Wavelet.resolutions(&settings) {
            let level = Level { resolution, ..Level::FULL };
            match DecodedFrame::at(decoder.as_ref(), frame, level) {
                Ok(decoded) => {
                    let layout = decoder.layout().at_resolution(resolution);
                    assert_eq!(decoded.values().len() as u64, layout.samples_per_frame());
                    assert!(decoded.values().iter().all(|v| v.is_finite()));
                }
                Err(error @ (DecodeError::Memory(_) | DecodeError::Failed(_))) => panic!("{error}"),
                Err(_) => decodes = false,
            }
        }
        if let Some(passes) = decoder.frame_decode() {
            // What a device gets of it is sound, or refused.
            let _ = passes.passes(frame, Level::FULL);
        }
    }
    decodes
}

/// Edits of any part of a stream.
fn edited(dice: &mut Dice, right: &Content) -> Content {
    let mut content = right.clone();
    for _ in 0..=dice.below(2) {
        let chunk = dice.below(content.lengths.len());
        match dice.below(10) {
            0 => {
                let step = dice.below(content.steps.len());
                let extreme =
                    [0.0, f32::MIN_POSITIVE, 1e-45, 1.0, 1e30, f32::MAX, -1.0, f32::NAN, f32::INFINITY];
                content.steps[step] = extreme[dice.below(extreme.len())].to_bits();
            }
            1 => {
                let (one, other) = (dice.below(content.lengths.len()), dice.roll() as u32);
                content.lengths.swap(one, chunk);
                if dice.below(4) == 0 {
                    content.lengths[one] = other;
                }
            }
            2 => {
                let (key, value) = [
                    ("decompositions", json!(dice.below(14))),
                    ("filter", json!((["haar", "5-3", "cdf-9-7", "coiflet-6"][dice.below(4)]))),
                    ("coder", json!((["contexts", "runs", "deflate-octree", "zerotree"][dice.below(4)]))),
                    ("paper", json!([dice.below(256), (["paper", "printed"][dice.below(2)])])),
                    ("correction", json!(([1e-30, 1.0, 3e38, -1.0][dice.below(4)]))),
                    ("range", json!({ "min": -3e38, "max": 3e38 })),
                    ("extent", json!([9, 17, 20])),
                ][dice.below(7)]
                .clone();
                content.parameters[key] = value;
            }
            _ => {
                let place = content.places()[chunk].clone();
                if place.end > content.chunks.len() {
                    continue; // a length was changed before
                }
                let mut own = content.chunks[place.clone()].to_vec();
                edit(dice, &mut own);
                content.lengths[chunk] = own.len() as u32;
                content.chunks.splice(place, own);
            }
        }
    }
    content
}

/// Whole streams with every coder, with corrections, of colours and frames, and with the paper's quantiser.
#[test]
fn no_stream_makes_a_decoder_panic() {
    let (mut decoded, mut tried) = (0, 0);
    for (coder, order) in CODERS {
        let with = |more: &[(&str, &str)]| {
            settings(&[&[("coder", coder), ("order", order), ("decompositions", "2")], more].concat())
        };
        for (settings, volume) in [
            (with(&[("max_error", "3"), ("filter", "cdf-9-7")]), volume(1, 1)),
            (with(&[("filter", "5-3")]), volume(1, 2)),
            (with(&[("filter", "coiflet-6"), ("quality", "200"), ("quant_scale", "printed")]), volume(3, 1)),
        ] {
            let like = encode_temporary(&Wavelet, &settings, &volume).unwrap();
            let right = Content::of(&like);
            assert!(survives(right.stream(&like)));
            let mut dice = Dice(7);
            for _ in 0..CASES / 20 {
                decoded += usize::from(survives(edited(&mut dice, &right).stream(&like)));
                tried += 1;
            }
        }
    }
    assert!(decoded > tried / 20 && decoded < tried - tried / 20, "{decoded} of {tried} decode");
}

/// Address space of a process that decodes hostile streams, in KiB. Threads and allocator take most of it.
const LIMIT_KIB: u32 = 1_500_000;

/// The tests above under a limit of memory, in a process of their own: a length that a stream promises, and that a
/// decoder believes, is refused by the allocator, which ends the process.
#[cfg(target_os = "linux")]
#[test]
fn hostile_lengths_take_no_memory() {
    let own = std::env::current_exe().unwrap();
    let limited = format!("ulimit -v {LIMIT_KIB} && exec \"$0\" \"$@\"");
    let ran = Command::new("sh")
        .args(["-c", &limited])
        .arg(own)
        .args(["--exact", "--test-threads", "1"])
        .args(["hostile::no_chunk_makes_a_coder_panic", "hostile::no_stream_makes_a_decoder_panic"])
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&ran.stdout);
    assert!(ran.status.success(), "{text}\n{}", String::from_utf8_lossy(&ran.stderr));
    assert!(text.contains("2 passed"), "{text}");
}
