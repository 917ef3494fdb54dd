//! Every voxel of every registered codec: the CPU decoder compared with the real generated shader.

use std::path::PathBuf;

use cvr::input::{self, Generator};
use cvr::registry;
use cvr_codec_tests::offering;
use cvr_core::codec::{Agreement, Codec, Parity, Settings, Site, VoxelDump, decode_stages};
use cvr_core::volume::{BrickSource as _, DenseVolume, Extent, FiniteVolume, FrameIndex, Level};
use cvr_core::volume::{NoReferences, Region, SampleType, Samples, VolumeLayout};
use cvr_engine::Device;
use cvr_engine::testing::test_device;

use super::subjects::{ODD, accepted, codec, encoded, noise, settings, sweep};

/// Dumps every level through `fetch`, and through `fetch_cell` if there is one. Returns the number of compared samples.
fn check(device: &Device, codec: &dyn Codec, settings: &Settings, volume: &FiniteVolume, name: &str) -> u64 {
    let info = codec.info();
    let Some(decoder) = accepted(codec, settings, volume) else { return 0 };
    let Some(shader) = decoder.shader() else {
        let offers = codec.offers(&info.complete(settings).unwrap(), Site::Inline);
        assert!(!offers, "{} {settings}: site inline, but no shader", info.id);
        return 0;
    };
    let mut samples = 0;
    let most = codec.stages(&info.complete(settings).unwrap());
    for stages in (1..most).chain([Level::ALL_STAGES]) {
        let key = (FrameIndex::FIRST, Level { stages, ..Level::FULL });
        let cpu = decode_stages(decoder.as_ref(), key.0, stages, &NoReferences).unwrap();
        for use_cell in [false, true].into_iter().take(1 + usize::from(info.fetch_cell)) {
            let dump = device.dump_at(info.id, decoder.as_ref(), key, use_cell).unwrap();
            let parity = Parity::compare_at(decoder.as_ref(), shader.agreement(), key, &cpu, &dump);
            let how = format!("stages: {stages}, cell: {use_cell}");
            assert!(parity.holds(), "{} {settings}, {name}, {how}: {parity}", info.id);
            assert_eq!(dump.len(), cpu.len());
            samples += parity.samples;
        }
    }
    samples
}

/// Settings in turn, from two beginnings, over all sample types.
#[test]
fn every_codec_setting_and_sample_type_on_odd_volumes() {
    let Some(device) = test_device("parity::odd_volumes") else { return };
    let volumes = SampleType::ALL.map(|sample| (format!("noise {sample}"), noise(ODD, sample)));
    for codec in registry::codecs().unwrap().iter() {
        // Sample types side by side, since they mostly share a shader.
        for settings in sweep(codec.as_ref(), 0) {
            for (name, volume) in &volumes {
                check(device, codec.as_ref(), &settings, volume, name);
            }
        }
    }
}

#[test]
fn every_codec_on_generated_volumes_of_64_cubed() {
    let Some(device) = test_device("parity::generated") else { return };
    let extent = Extent::cube(64).unwrap();
    let generators = Generator::ALL.into_iter().cycle();
    let volumes: Vec<_> = [SampleType::U8, SampleType::I16, SampleType::F32]
        .into_iter()
        .zip(generators)
        .map(|(sample, kind)| {
            let volume = FiniteVolume::new(input::generate(kind, extent, sample, 7).unwrap());
            (format!("{kind} {sample}"), volume)
        })
        .collect();
    for codec in registry::codecs().unwrap().iter() {
        for (i, settings) in sweep(codec.as_ref(), 1).iter().enumerate() {
            let (name, volume) = &volumes[i % volumes.len()];
            check(device, codec.as_ref(), settings, volume, name);
        }
    }
}

/// A cube and a box of odd edges, each with every width of index.
#[test]
fn s3dc_cubes_and_boxes_with_every_index_width() {
    let Some(device) = test_device("parity::s3dc_blocks") else { return };
    let samples = SampleType::ALL.into_iter().cycle();
    let blocks = ["4", "5x3x7"].into_iter().flat_map(|block| ["1", "2", "4", "8"].map(|bits| (block, bits)));
    for ((block, bits), sample) in blocks.zip(samples) {
        let settings = settings(&[("block", block), ("index_bits", bits)]);
        check(device, codec("s3dc").as_ref(), &settings, &noise(ODD, sample), &format!("noise {sample}"));
    }
}

#[test]
fn native_and_half_samples_promise_to_be_exact() {
    for (bits, sample) in [("native", SampleType::F32), ("native", SampleType::I16), ("half", SampleType::U8)]
    {
        let volume = noise([3, 2, 2], sample);
        let decoder = encoded(codec("raw").as_ref(), &settings(&[("bits", bits)]), &volume);
        // The sweeps above use this stated agreement. It must not become weaker.
        assert_eq!(decoder.shader().unwrap().agreement(), Agreement::Exact, "{bits} {sample}");
    }
}

#[test]
fn every_codec_on_a_real_volume() {
    let Some(device) = test_device("parity::real_volume") else { return };
    let Some(folder) = std::env::var_os("CVR_DATA").map(PathBuf::from) else {
        println!("skipped parity::real_volume: CVR_DATA names no folder of real volumes");
        return;
    };
    let whole = FiniteVolume::new(input::open(&folder.join("bonsai.nrrd")).unwrap());
    // More voxels than one row of workgroups holds concern the dump, not codecs. One codec is enough.
    let part = cut(&whole, [64; 3], [128, 128, 128]);
    for codec in registry::codecs().unwrap().iter() {
        let Some(settings) = offering(codec.as_ref(), Site::Inline) else { continue };
        let volume = if codec.info().id == "raw" { &whole } else { &part };
        let samples = check(device, codec.as_ref(), &settings, volume, "bonsai");
        assert!(samples >= volume.layout().samples(), "{}: {samples} samples compared", codec.info().id);
    }
}

/// A box of a volume's first frame, as a volume.
fn cut(volume: &FiniteVolume, origin: [u32; 3], size: [u32; 3]) -> FiniteVolume {
    let extent = Extent::try_from(size).unwrap();
    let layout = VolumeLayout { extent, frames: 1, ..volume.layout().clone() };
    let mut values = vec![0.0; layout.samples() as usize];
    volume.read(FrameIndex::FIRST, Region { origin, extent }, &mut values).unwrap();
    let samples = Samples::U8(values.into_iter().map(|value| value as u8).collect());
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}
