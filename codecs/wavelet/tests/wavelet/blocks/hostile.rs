//! Streams that no encoder wrote are refused, or decode to something. Nothing is read outside.

use std::sync::Arc;

use cvr_codec_tests::{bytes, hash};
use cvr_core::codec::{Codec as _, decode_frame};
use cvr_core::container::{ContainerWriter, Element, EncodedVolume, StreamWriter as _};
use cvr_core::kit::{FetchVoxels as _, StreamReader as _};
use cvr_core::volume::{FrameIndex, Level, NoReferences, Region};
use cvr_wavelet::blocks::Reader;

use cvr_wavelet::Wavelet as Blocks;

use super::codec::{METHODS, encoded, of};

/// A stream's words and parameters.
#[derive(Clone)]
struct Content {
    table: Vec<u32>,
    bits: Vec<u32>,
    parameters: serde_json::Value,
}

impl Content {
    fn of(stream: &EncodedVolume) -> Self {
        let words = |name| stream.tensor(name, Element::U32).unwrap().words().to_vec();
        Self { table: words("table"), bits: words("bits"), parameters: stream.spec().parameters.clone() }
    }

    /// A sound container of it.
    fn stream(&self, like: &EncodedVolume) -> EncodedVolume {
        let (spec, folder) = (like.spec(), tempfile::tempdir().unwrap());
        let path = folder.path().join("changed.cvr");
        let mut writer = ContainerWriter::create(&path).unwrap();
        for (name, words) in [("table", &self.table), ("bits", &self.bits)] {
            let all: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            writer.append(name, Element::U32, &all).unwrap();
        }
        writer.shape("table", &spec.tensors["table"].shape).unwrap();
        writer.parameters(self.parameters.clone());
        writer.finish(Blocks.info(), &spec.layout, &spec.settings, &spec.report, spec.replaced).unwrap();
        EncodedVolume::open(&path).unwrap()
    }
}

/// Decodes all that a stream has, by blocks, cells and voxels. Whether it was opened.
fn survives(stream: EncodedVolume) -> bool {
    let stream = Arc::new(stream);
    let Ok(reader) = Reader::open(&stream) else { return false };
    let extent = stream.spec().layout.extent;
    for frame in (0..stream.spec().layout.frames).map(FrameIndex) {
        let all = decode_frame(&reader, frame, &NoReferences).unwrap();
        assert!(all.iter().all(|v| v.is_finite()));
        let voxels = reader.frame(frame, Level::FULL);
        for (p, v) in Region::whole(extent).positions().zip(all).step_by(7) {
            assert_eq!(voxels.fetch(p)[0], v);
            let q = [0, 1, 2].map(|a| (p[a] + 1).min(extent.to_array()[a] - 1));
            assert_eq!(voxels.fetch_cell(p, q)[0][0], v);
        }
    }
    true
}

#[test]
fn no_stream_makes_a_reader_panic() {
    let volume = bytes([20, 17, 9], 1, 2, |p, _, f| hash(p, f) / 4 + (p[0] * p[1] / 2) as u8 / 2);
    let mut state = 1_u32;
    let mut random = move |below: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize % below
    };
    let (mut opened, mut tried) = (0, 0);
    for method in METHODS {
        for (target, value) in [("rate", "4"), ("lossless", "")] {
            let like = encoded(&volume, &of(method, target, value)).unwrap();
            let right = Content::of(&like);
            assert!(survives(right.stream(&like)));
            for i in 0..60 {
                let mut content = right.clone();
                let (table, bits) = (&mut content.table, &mut content.bits);
                match i % 6 {
                    0 => bits[random(right.bits.len())] ^= 1 << random(32),
                    1 => table[random(right.table.len())] ^= 1 << random(32),
                    2 => bits.iter_mut().for_each(|word| *word = (random(1 << 16) * random(1 << 16)) as u32),
                    3 => table.iter_mut().for_each(|entry| *entry = random(4 * right.bits.len() + 9) as u32),
                    4 => {
                        let words = random(right.bits.len());
                        bits.truncate(words);
                        content.parameters["frame_words"] = serde_json::json!([words / 2, words - words / 2]);
                    }
                    _ => {
                        let (key, value) = [
                            ("low_bits", serde_json::json!(random(40))),
                            ("low_base", serde_json::json!(i32::MIN + random(9) as i32)),
                            ("low_step", serde_json::json!(i32::MAX - random(9) as i32)),
                            ("block", serde_json::json!(8 << random(2))),
                            ("filter", serde_json::json!("5-3")),
                            ("frame_words", serde_json::json!([u64::MAX, 2])),
                        ][random(6)]
                        .clone();
                        content.parameters[key] = value;
                    }
                }
                opened += usize::from(survives(content.stream(&like)));
                tried += 1;
            }
        }
    }
    assert!(opened > tried / 10 && opened < tried, "{opened} of {tried} were opened");
}
