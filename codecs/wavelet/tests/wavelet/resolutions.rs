//! Coarse resolutions: what they look like, and what of a stream they read.

use std::ops::Range;
use std::sync::Arc;

use cvr_codec_tests::{bytes, hash, settings};
use cvr_core::codec::{Codec as _, DecodeError, DecodedFrame, Settings, encode_temporary};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::{FiniteVolume, FrameIndex, Level};
use cvr_wavelet::Wavelet;

use super::whole::{CODERS, Content};

/// A ball with grain.
fn ball() -> FiniteVolume {
    bytes([61, 50, 47], 1, 1, |p, _, _| {
        let [x, y, z] = [p[0] as i32 - 30, p[1] as i32 - 22, p[2] as i32 - 25];
        let inside = x * x + y * y + z * z < 400;
        if inside { 180 + hash(p, 0) / 32 } else { 40 + p[0] as u8 }
    })
}

fn encoded(volume: &FiniteVolume, settings: &Settings) -> Arc<EncodedVolume> {
    Arc::new(encode_temporary(&Wavelet, settings, volume).unwrap())
}

fn decoded(stream: &Arc<EncodedVolume>, resolution: u8) -> Result<Arc<DecodedFrame>, DecodeError> {
    let decoder = Wavelet.decoder(Arc::clone(stream))?;
    DecodedFrame::at(decoder.as_ref(), FrameIndex::FIRST, Level { resolution, ..Level::FULL })
}

/// There are as many as the codec says, each of half the size.
#[test]
fn each_decomposition_is_a_resolution() {
    let volume = ball();
    for filter in ["haar", "cdf-9-7", "5-3"] {
        let settings = settings(&[("filter", filter), ("decompositions", "3")]);
        let complete = Wavelet.info().complete(&settings).unwrap();
        assert_eq!(Wavelet.resolutions(&complete), 4);
        let stream = encoded(&volume, &settings);
        let mut size = [61_u32, 50, 47];
        for resolution in 0..4 {
            let frame = decoded(&stream, resolution).unwrap();
            assert_eq!(frame.layout().extent.to_array(), size, "{filter} {resolution}");
            // Voxels are means of the volume's: the ball is bright, and what lies around it is not.
            let at = |p: [u32; 3]| frame.values()[frame.layout().extent.index(p.map(|n| n >> resolution))];
            assert!((170.0..=200.0).contains(&at([30, 22, 25])), "{filter} {resolution}");
            assert!((30.0..=60.0).contains(&at([1, 1, 1])), "{filter} {resolution}");
            size = size.map(|n| n.div_ceil(2));
        }
        let refused = decoded(&stream, 4).unwrap_err().to_string();
        assert!(refused.contains('4'), "{refused}");
    }
}

/// Bytes that only the full resolution needs, of a stream of one channel: whole chunks; of zerotrees, whose chunks have
/// all levels, the last bytes.
fn finest(content: &Content, coder: &str, is_corrected: bool) -> Vec<Range<usize>> {
    let places = content.places();
    let (of_coder, corrections) = places.split_at(places.len() - usize::from(is_corrected));
    let mut finest: Vec<Range<usize>> = match coder {
        "contexts" => of_coder[1..].to_vec(),
        "zerotree" => of_coder[1..].iter().map(|place| place.end - 2..place.end).collect(),
        _ => of_coder[of_coder.len() - 7..].to_vec(),
    };
    finest.extend_from_slice(corrections);
    finest
}

/// A coarse resolution reads nothing of the finer ones: with other bytes there, it is the same.
#[test]
fn finer_chunks_are_not_read() {
    let volume = ball();
    for (coder, order) in CODERS {
        for target in [("psnr", "45"), ("max_error", "2")] {
            let settings = settings(&[("coder", coder), ("order", order), ("decompositions", "2"), target]);
            let stream = encoded(&volume, &settings);
            let mut content = Content::of(&stream);
            let places = finest(&content, coder, target.0 == "max_error");
            assert!(places.iter().all(|place| !place.is_empty()), "{coder} {order}: an empty chunk");
            places.into_iter().for_each(|place| content.chunks[place].iter_mut().for_each(|b| *b = !*b));
            let changed = content.stream(&stream);
            for resolution in [1, 2] {
                let [a, b] = [&stream, &changed].map(|stream| decoded(stream, resolution).unwrap());
                assert!(a.values() == b.values(), "{coder} {order}, resolution {resolution}");
            }
            // The failing twin: the full resolution reads them.
            let whole = decoded(&stream, 0).unwrap();
            let other = decoded(&changed, 0).map(|frame| frame.values() == whole.values());
            assert!(!other.unwrap_or(false), "{coder} {order}: the finest chunks say nothing");
        }
    }
}
