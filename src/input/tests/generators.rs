//! The test signals against an implementation of the same definitions in another language, voxel by voxel.

use cvr_core::volume::{BrickSource as _, DenseVolume, Extent, SampleType, Samples};

use crate::input::{Generator, generate, generate_frames};

fn extent(x: u32, y: u32, z: u32) -> Extent {
    Extent::new(x, y, z).unwrap()
}

fn integers(volume: &DenseVolume) -> Vec<u64> {
    (0..volume.samples().len()).map(|i| volume.samples().get(i) as u64).collect()
}

/// Sum, minimum, maximum, middle sample, and the sum of index × sample modulo 2^32, which sees every swap.
fn facts(volume: &DenseVolume) -> [u64; 5] {
    let v = integers(volume);
    let weighted = v.iter().zip(0..).map(|(s, i)| s * i).sum::<u64>() % (1 << 32);
    [v.iter().sum(), *v.iter().min().unwrap(), *v.iter().max().unwrap(), v[v.len() / 2], weighted]
}

#[test]
fn agree_with_an_independent_implementation() {
    for (kind, u8s, i16s) in [
        (
            Generator::SheppLogan,
            [98_780, 0, 255, 51, 250_948_382],
            [71_878_587, 0, 32_767, 6553, 4_069_399_087],
        ),
        (
            Generator::MarschnerLobb,
            [637_597, 0, 255, 153, 1_086_403_507],
            [454_796_886, 37, 32_730, 19_659, 3_696_255_085],
        ),
        (
            Generator::Turbulence,
            [398_460, 9, 199, 82, 991_294_207],
            [279_331_112, 706, 25_658, 11_145, 3_071_602_486],
        ),
        (
            Generator::AdvectedBlobs,
            [45_075, 0, 255, 103, 85_329_631],
            [31_600_898, 0, 32_767, 13_136, 4_219_523_914],
        ),
        (
            Generator::WhiteNoise,
            [648_043, 0, 255, 101, 1_653_949_416],
            [451_550_373, 0, 32_764, 832, 1_888_713_344],
        ),
    ] {
        let small = generate(kind, extent(13, 17, 23), SampleType::U8, 7).unwrap();
        let large = generate(kind, extent(40, 33, 21), SampleType::I16, 7).unwrap();
        assert_eq!((facts(&small), facts(&large)), (u8s, i16s), "{kind}");
    }
}

#[test]
fn the_seeded_ones_depend_on_the_seed() {
    for kind in Generator::ALL {
        let [a, b] = [7, 8].map(|seed| generate(kind, extent(13, 17, 23), SampleType::U8, seed).unwrap());
        let is_seeded = !matches!(kind, Generator::SheppLogan | Generator::MarschnerLobb);
        assert_eq!(a != b, is_seeded, "{kind}");
    }
    let other = generate(Generator::Turbulence, extent(13, 17, 23), SampleType::U8, 8).unwrap();
    assert_eq!(integers(&other).iter().sum::<u64>(), 400_246);
}

/// Frames 20 and all 24, as above by an implementation in another language.
#[test]
fn blobs_move_as_they_should() {
    let size = extent(13, 17, 23);
    let series = |frames| generate_frames(Generator::AdvectedBlobs, size, frames, SampleType::U8, 7).unwrap();
    let all = series(24);
    assert_eq!((all.layout().frames, facts(&all)), (24, [1_050_833, 0, 255, 0, 2_563_340_946]));
    let Samples::U8(v) = all.samples() else { panic!("8 bits") };
    let frames: Vec<&[u8]> = v.chunks_exact(size.voxels() as usize).collect();
    assert_eq!(frames[20].iter().map(|&s| u64::from(s)).sum::<u64>(), 42_662);
    assert!(frames.windows(2).all(|w| w[0] != w[1]), "each frame differs from the next");
    let Samples::U8(few) = series(3).samples().clone() else { panic!("8 bits") };
    assert!(v.starts_with(&few), "a frame does not depend on how many follow");
}

#[test]
fn what_stands_still_repeats_its_frame() {
    let size = extent(5, 4, 3);
    for kind in Generator::ALL.into_iter().filter(|kind| *kind != Generator::AdvectedBlobs) {
        let one = generate(kind, size, SampleType::I16, 1).unwrap();
        let three = generate_frames(kind, size, 3, SampleType::I16, 1).unwrap();
        let Samples::I16(one) = one.samples() else { panic!("16 bits") };
        assert_eq!(three.samples(), &Samples::I16(one.repeat(3)), "{kind}");
    }
    let none = generate_frames(Generator::SheppLogan, size, 0, SampleType::I16, 1);
    assert!(none.unwrap_err().to_string().contains("at least one frame"));
}

#[test]
fn every_type_holds_the_same_signal() {
    for kind in Generator::ALL {
        let signal = generate(kind, extent(9, 8, 7), SampleType::F32, 1).unwrap();
        let Samples::F32(values) = signal.samples() else { panic!("asked for f32") };
        assert!(values.iter().all(|v| (0.0..=1.0).contains(v)), "{kind}");
        for sample in SampleType::ALL {
            let volume = generate(kind, extent(9, 8, 7), sample, 1).unwrap();
            assert_eq!(volume.layout().sample, sample);
            assert_eq!(volume.layout().spacing, [1.0; 3]);
            let top = sample.integer_range().map_or(1.0, |(_, max)| max as f32);
            for (i, v) in values.iter().enumerate() {
                assert!((volume.samples().get(i) - v * top).abs() <= 0.501, "{kind} {sample} at {i}");
            }
        }
    }
}

#[test]
fn thin_and_single_voxel_volumes() {
    let values = [
        (Generator::SheppLogan, 51),
        (Generator::MarschnerLobb, 153),
        (Generator::Turbulence, 82),
        (Generator::WhiteNoise, 44),
    ];
    for (kind, value) in values {
        let one = generate(kind, Extent::ONE, SampleType::U8, 7).unwrap();
        assert_eq!(one.samples(), &Samples::U8(vec![value]), "{kind}");
        for thin in [extent(1, 50, 1), extent(50, 1, 1), extent(1, 1, 50)] {
            assert_eq!(generate(kind, thin, SampleType::U16, 7).unwrap().samples().len(), 50);
        }
    }
}

/// The slice z = 0 is the phantom of 1974: bone, brain, both ventricles (turned opposite ways), outside.
#[test]
fn shepp_logan_looks_like_a_head() {
    let n = 201;
    let volume = generate(Generator::SheppLogan, extent(n, n, 3), SampleType::F32, 0).unwrap();
    let at = |x: f64, y: f64| {
        let voxel = |c: f64| ((c + 1.0) / 2.0 * f64::from(n)) as u32;
        volume.samples().get(volume.layout().extent.index([voxel(x), voxel(y), 1]))
    };
    let near = |a: f32, b: f32| (a - b).abs() < 1e-6;
    assert!(near(at(0.0, -0.9), 1.0), "bone");
    assert!(near(at(0.0, 0.7), 0.2), "brain");
    assert!(near(at(0.22, 0.0), 0.0) && near(at(-0.22, 0.0), 0.0), "ventricles");
    assert!(near(at(0.30, 0.25), 0.0) && near(at(0.30, -0.25), 0.2), "the right one leans right");
    assert!(near(at(-0.32, 0.33), 0.0) && near(at(-0.32, -0.33), 0.2), "the left one leans left");
    assert!(near(at(0.95, 0.95), 0.0), "outside");
}

#[test]
fn too_large_is_refused_before_it_is_computed() {
    let error = generate(Generator::Turbulence, extent(8192, 8192, 64), SampleType::F32, 0).unwrap_err();
    assert_eq!(
        error.to_string(),
        "generator turbulence: 8192×8192×64 voxels take 17179869184 bytes, \
         more than the limit of 8589934592 (2^33); crop or downsample the volume"
    );
}

#[test]
fn names_lead_back() {
    for kind in Generator::ALL {
        assert_eq!(Generator::from_name(kind.name()), Some(kind));
        assert_eq!(serde_json::to_value(kind).unwrap(), kind.name());
    }
    assert_eq!(Generator::from_name("noise"), None);
}
