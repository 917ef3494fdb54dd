//! Properties of the encoder beyond the conformance tests: the bits of BC4 as other decoders read them, independent
//! channels and frames, a search that beats the range, and equal output for any number of threads.

use std::sync::Arc;

use cvr_bc4::block::{Ends, TEXELS, pack};
use cvr_bc4::{BC4, Quality, encode_block};
use cvr_codec_tests::{bytes, hash, settings};
use cvr_core::codec::{
    Codec as _, Decoder, Progress, TexelFormat, decode_frame, encode_file, encode_temporary,
};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::{
    BrickKey, DenseVolume, Extent, FiniteVolume, FrameIndex, Level, NoReferences, Region, Replaced,
    SampleType, Samples, VolumeLayout,
};

fn encoded(volume: &FiniteVolume, pairs: &[(&str, &str)]) -> Arc<EncodedVolume> {
    Arc::new(encode_temporary(&BC4, &settings(pairs), volume).unwrap())
}

fn decoder(stream: &Arc<EncodedVolume>) -> Box<dyn Decoder> {
    BC4.decoder(Arc::clone(stream)).unwrap()
}

fn decoded(volume: &FiniteVolume, frame: u32) -> Vec<f32> {
    let stream = encoded(volume, &[]);
    decode_frame(decoder(&stream).as_ref(), FrameIndex(frame), &NoReferences).unwrap()
}

fn squared_error(volume: &FiniteVolume, quality: &str) -> f64 {
    let stream = encoded(volume, &[("quality", quality)]);
    let decoded = decode_frame(decoder(&stream).as_ref(), FrameIndex::FIRST, &NoReferences).unwrap();
    let source = volume.dense().frame_values(FrameIndex::FIRST);
    decoded.iter().zip(source).map(|(d, s)| f64::from(d - s).powi(2)).sum()
}

/// Another implementation's 8-bit result for a block, with fractions cut off.
fn by_another(words: [u32; 2]) -> [u8; TEXELS] {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let mut pixels = [0_u32; TEXELS];
    texture2ddecoder::decode_bc4_block(&bytes, &mut pixels);
    pixels.map(|pixel| (pixel >> 16) as u8)
}

/// Every pair of endpoints with every index: the other decoder returns our level truncated or rounded.
#[test]
fn another_decoder_reads_the_same_levels() {
    let indices = std::array::from_fn(|i| (i * 5 % 8) as u8);
    for (first, second) in (0..=255).flat_map(|a| (0..=255).map(move |b| (a, b))) {
        let ends = Ends([first, second]);
        let found = by_another(pack(ends, &indices));
        for (index, found) in indices.into_iter().zip(found) {
            let parts = ends.levels()[index as usize];
            let [down, up] = [parts / 35, (parts + 34) / 35];
            assert!((down..=up).contains(&i16::from(found)), "{first} {second}, index {index}: {found}");
        }
    }
}

/// The comparison above can fail: indices in another order are other levels.
#[test]
fn another_decoder_notices_another_order() {
    let indices: [u8; TEXELS] = std::array::from_fn(|i| (i * 5 % 8) as u8);
    let mut turned = indices;
    turned.reverse();
    assert_ne!(by_another(pack(Ends([200, 20]), &indices)), by_another(pack(Ends([200, 20]), &turned)));
    assert_ne!(by_another(pack(Ends([200, 20]), &indices)), by_another(pack(Ends([20, 200]), &indices)));
}

/// A whole volume. Its blocks are read from the tensor as the README specifies.
#[test]
fn another_decoder_reads_our_volumes() {
    let volume = bytes([13, 10, 3], 1, 1, |p, _, _| hash(p, 5) / 3 + (p[0] * 9) as u8);
    let stream = encoded(&volume, &[]);
    let words = stream.tensor("blocks", cvr_core::container::Element::U32).unwrap();
    let own = decoded(&volume, 0);
    for (block, words) in words.words().chunks_exact(2).enumerate() {
        let (column, row, z) = (block % 4, block / 4 % 3, block / 12);
        for (texel, found) in by_another([words[0], words[1]]).into_iter().enumerate() {
            let (x, y) = (column * 4 + texel % 4, row * 4 + texel / 4);
            if x < 13 && y < 10 {
                let own = own[(z * 10 + y) * 13 + x];
                assert!((own - f32::from(found)).abs() <= 1.0, "{x} {y} {z}: {own}, {found}");
            }
        }
    }
}

#[test]
fn each_channel_of_each_frame_is_coded_as_if_alone() {
    let value = |p: [u32; 3], c: u32, f: u32| hash(p, 7 * c + f) >> (1 + c);
    let together = bytes([13, 6, 5], 3, 2, value);
    for f in 0..2 {
        let all = decoded(&together, f);
        for c in 0..3 {
            let alone = decoded(&bytes([13, 6, 5], 1, 1, |p, _, _| value(p, c, f)), 0);
            let channel: Vec<f32> = all.iter().skip(c as usize).step_by(3).copied().collect();
            assert!(channel == alone, "channel {c} of frame {f} differs");
        }
    }
}

#[test]
fn what_a_block_can_hold_is_exact() {
    // Blocks with at most two values, or codes between two endpoints, or 0 and 255 next to six levels.
    for value in [
        |p: [u32; 3]| (p[0] / 4 * 31 + p[1] / 4 * 7 + p[2]) as u8,
        |p: [u32; 3]| ((p[0] + p[1]) % 8 * 3 + p[2] * 11) as u8,
        |p: [u32; 3]| [0, 255, 90, 91][((p[0] + p[1]) % 4) as usize],
    ] {
        let volume = bytes([16, 12, 3], 1, 1, |p, _, _| value(p));
        let stream = encoded(&volume, &[]);
        let frame = volume.dense().frame_values(FrameIndex::FIRST);
        let decoded = decoded(&volume, 0);
        assert!(decoded.iter().zip(&frame).all(|(d, s)| d.round() == *s));
        assert_eq!(stream.spec().report.error_bound, Some(0.0));
    }
}

#[test]
fn the_search_is_better_than_the_range() {
    let noise = bytes([32, 32, 4], 1, 1, |p, _, _| hash(p, 3));
    let soft = bytes([32, 32, 4], 1, 1, |p, _, _| hash(p, 3) / 8 + (p[0] * p[1] / 6) as u8);
    for volume in [noise, soft] {
        let [range, search] = ["range", "search"].map(|quality| squared_error(&volume, quality));
        assert!(search < 0.9 * range, "{search} after the search, {range} without");
    }
}

#[test]
fn blocks_are_half_a_byte_a_voxel_and_a_texture_as_they_are() {
    let volume = bytes([16, 8, 5], 1, 2, |p, _, f| hash(p, f));
    let stream = encoded(&volume, &[]);
    let decoder = decoder(&stream);
    for frame in [0, 1] {
        let blocks = decoder.block_texture(FrameIndex(frame), Level::FULL).unwrap();
        assert_eq!((blocks.words.len() * 4, blocks.scale, blocks.offset), (16 * 8 * 5 / 2, 255.0, 0.0));
        let shader = decoder.shader().unwrap().resources(FrameIndex(frame)).unwrap();
        assert_eq!(blocks.words, shader[0].words);
    }
    assert!(decoder.block_texture(FrameIndex(2), Level::FULL).is_none());
}

/// Every level is a texel value: a texture of 16 bits holds what the CPU decodes.
#[test]
fn a_texel_is_a_level() {
    let volume = bytes([16, 16, 3], 1, 1, |p, _, _| hash(p, 9));
    let form = decoder(&encoded(&volume, &[])).decoded_form();
    assert_eq!((form.format, form.offset), (TexelFormat::Unorm16, 0.0));
    for value in decoded(&volume, 0) {
        let texel = f64::from(value) / f64::from(form.scale) * 65535.0;
        assert!(
            (texel - texel.round()).abs() < 0.02 && (texel.round() as u32).is_multiple_of(7),
            "{value}: {texel}"
        );
    }
}

/// The decoder's range of a box is the range of its blocks, extended to code 0.
#[test]
fn a_value_range_is_that_of_the_blocks() {
    let extent = Extent::new(8, 8, 2).unwrap();
    let layout = VolumeLayout::scalar(extent, SampleType::I16);
    let value = |i: u64| if i < 64 { 500 } else { -300 - (i % 8) as i16 / 4 * 100 };
    let volume =
        FiniteVolume::new(DenseVolume::new(layout, Samples::I16((0..128).map(value).collect())).unwrap());
    let stream = encoded(&volume, &[]);
    let decoder = decoder(&stream);
    let range = |origin, size| {
        let region = Region { origin, extent: Extent::try_from(size).unwrap() };
        let range = decoder.value_range(BrickKey::full(FrameIndex::FIRST, region)).unwrap();
        // In codes: 255 of them cover -400 to 500.
        [range.min, range.max].map(|v| ((v + 400.0) * 255.0 / 900.0).round())
    };
    assert_eq!(range([0; 3], [8, 8, 1]), [0.0, 255.0]);
    let [low, high] = range([0, 0, 1], [4, 8, 1]);
    assert!(low == 0.0 && (28.0..=30.0).contains(&high), "{high}");
    assert_eq!(range([5, 0, 1], [1, 1, 1]), [0.0, 0.0]);
}

#[test]
fn any_number_of_threads_gives_the_same_file() {
    let volume = bytes([40, 33, 21], 1, 1, |p, _, _| hash(p, 9) / 8 + (p[0] * p[1] / 9) as u8);
    let folder = tempfile::tempdir().unwrap();
    let on = |threads: usize| {
        let path = folder.path().join(format!("{threads}.cvr"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let settings = settings(&[]);
            encode_file(&BC4, &settings, &volume, Replaced::default(), &path, &Progress::silent()).unwrap();
        });
        std::fs::read(path).unwrap()
    };
    let one = on(1);
    assert!(one == on(2) && one == on(4), "the bytes depend on the number of threads");
}

#[test]
fn a_range_that_overflows_is_refused() {
    let layout = VolumeLayout::scalar(Extent::new(2, 1, 1).unwrap(), SampleType::F32);
    for (values, told) in [([-3e38, 3e38], "overflows"), ([0.0, 1e-34], "too small")] {
        let dense = DenseVolume::new(layout.clone(), Samples::F32(values.to_vec())).unwrap();
        let refused = encode_temporary(&BC4, &settings(&[]), &FiniteVolume::new(dense)).unwrap_err();
        assert!(refused.to_string().contains(told), "{refused}");
    }
}

/// The words that the README shows.
#[test]
fn the_block_of_the_readme() {
    let wanted = std::array::from_fn(|i| [70, 0, 60, 50, 40, 30, 20, 10][i % 8] * 35);
    let words = encode_block(&wanted, Quality::Range);
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    assert_eq!(bytes, [0x46, 0x00, 0x88, 0xc6, 0xfa, 0x88, 0xc6, 0xfa]);
}
