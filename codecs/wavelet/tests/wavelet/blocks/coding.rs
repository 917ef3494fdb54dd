//! Properties of streams: nothing is lost without loss, constant blocks cost their entries, and threads change nothing.

use cvr_codec_tests::{bytes, hash};
use cvr_core::codec::{Codec as _, Progress, encode_file};
use cvr_core::container::Element;
use cvr_core::kit::{FetchVoxels as _, StreamReader as _};
use cvr_core::volume::{
    DenseVolume, Extent, FiniteVolume, FrameIndex, Level, Region, Replaced, SampleType, Samples, VolumeLayout,
};
use cvr_wavelet::blocks::{Parameters, Reader};
use proptest::prelude::*;

use cvr_wavelet::Wavelet as Blocks;

use super::codec::{METHODS, decoded, encoded, of, source};

/// Smooth but for some noise, in the whole range of the type.
fn varied(size: [u32; 3], sample: SampleType, channels: u32, frames: u32, seed: u32) -> FiniteVolume {
    let extent = Extent::try_from(size).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, sample) };
    let value = |i: u64| -> f64 {
        let i = i as u32;
        let noise = hash([i, i >> 7, 3], seed);
        let t = if noise > 250 {
            f64::from(noise & 1)
        } else {
            f64::from(i % 999 + u32::from(noise) / 16) / 1015.0
        };
        let (low, high) = sample.integer_range().map_or((-3.5, 7.25), |(l, h)| (l.into(), h.into()));
        low + t * (high - low)
    };
    let values = (0..layout.samples()).map(value);
    let samples = match sample {
        SampleType::U8 => Samples::U8(values.map(|v| v.round() as u8).collect()),
        SampleType::I8 => Samples::I8(values.map(|v| v.round() as i8).collect()),
        SampleType::U16 => Samples::U16(values.map(|v| v.round() as u16).collect()),
        SampleType::I16 => Samples::I16(values.map(|v| v.round() as i16).collect()),
        _ => Samples::F32(values.map(|v| v as f32).collect()),
    };
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

#[test]
fn lossless_blocks_lose_nothing() {
    for method in METHODS {
        for sample in SampleType::ALL.into_iter().filter(|sample| sample.is_integer()) {
            for (size, channels, frames) in [([23, 9, 17], 1, 1), ([1, 1, 1], 1, 2), ([9, 8, 5], 3, 2)] {
                let volume = varied(size, sample, channels, frames, 5);
                let stream = encoded(&volume, &of(method, "lossless", "")).unwrap();
                assert_eq!(decoded(&stream), source(&volume), "{method:?} {sample} {size:?}");
                assert_eq!(stream.spec().report.error_bound, Some(0.0));
            }
        }
    }
}

#[test]
fn constant_blocks_cost_their_entries() {
    for method in METHODS {
        for (target, value) in [("lossless", ""), ("rate", "8"), ("psnr", "2"), ("max_error", "2")] {
            let volume = bytes([33, 17, 9], 3, 2, |_, _, _| 77);
            let stream = encoded(&volume, &of(method, target, value)).unwrap();
            assert!(decoded(&stream).iter().all(|v| *v == 77.0));
            let words = |name| stream.tensor(name, Element::U32).map_or(0, |tensor| tensor.words().len());
            let edge: u32 = method.1.parse().unwrap();
            let blocks = [33, 17, 9_u32].iter().map(|n| n.div_ceil(edge)).product::<u32>();
            assert_eq!((words("bits"), words("table") as u32), (0, blocks * 3 * 2), "{method:?} {target}");
        }
    }
}

#[test]
fn the_parameters_say_that_these_are_blocks() {
    let stream =
        encoded(&bytes([9, 8, 5], 1, 1, |p, _, _| hash(p, 1)), &of(METHODS[2], "psnr", "30")).unwrap();
    assert_eq!(stream.spec().parameters["mode"], "blocks");
    assert_eq!(stream.spec().parameters["filter"], "5-3");
    assert_eq!(stream.parameters::<Parameters>().unwrap().steps.len(), 3);
}

#[test]
fn any_number_of_threads_gives_the_same_file() {
    let volume = bytes([40, 33, 21], 3, 1, |p, c, _| hash(p, 9 + c) / 8 + (p[0] * p[1] / 9) as u8);
    let folder = tempfile::tempdir().unwrap();
    for method in METHODS {
        let on = |threads: usize| {
            let path = folder.path().join(format!("{threads}.cvr"));
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let settings = Blocks.info().complete(&of(method, "psnr", "40")).unwrap();
            pool.install(|| {
                encode_file(&Blocks, &settings, &volume, Replaced::default(), &path, &Progress::silent())
                    .unwrap();
            });
            std::fs::read(path).unwrap()
        };
        assert!(on(1) == on(4), "{method:?}: the bytes depend on the number of threads");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]
    /// Voxels are decoded one by one, by cells, and by whole blocks, on ways of their own.
    #[test]
    fn a_voxel_is_the_same_alone_in_a_cell_and_in_its_block(
        size in [1_u32..36, 1_u32..20, 1_u32..20],
        method in 0_usize..4,
        sample in 0_usize..5,
        rgb: bool,
        value in 1.2_f64..12.0,
        seed: u32,
    ) {
        let volume = varied(size, SampleType::ALL[sample], if rgb { 3 } else { 1 }, 1, seed);
        // A small volume may need more than the rate for its table.
        let Ok(stream) = encoded(&volume, &of(METHODS[method], "psnr", &(value * 6.0).to_string())) else {
            return Err(TestCaseError::fail("refused"));
        };
        let reader = Reader::open(&stream).unwrap();
        let frame = reader.frame(FrameIndex::FIRST, Level::FULL);
        let channels = if rgb { 3 } else { 1 };
        let all = decoded(&stream);
        for (p, voxel) in Region::whole(Extent::try_from(size).unwrap()).positions().zip(all.chunks_exact(channels)) {
            prop_assert_eq!(&frame.fetch(p)[..channels], voxel, "{:?}", p);
            let q = [0, 1, 2].map(|a| (p[a] + 1).min(size[a] - 1));
            let expected: [_; 8] = std::array::from_fn(|i| {
                frame.fetch([0, 1, 2].map(|a| if i >> a & 1 == 0 { p[a] } else { q[a] }))
            });
            prop_assert_eq!(frame.fetch_cell(p, q), expected, "{:?}", p);
        }
    }
}
