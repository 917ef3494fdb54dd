//! Streams that texture units decode: voxels compared with the CPU decoder, pictures with the mirror, and the remarks
//! in records.

use std::path::PathBuf;
use std::sync::Arc;

use cvr::estimate::{Allowance, Trials};
use cvr::experiment::records::record::{Record, Status};
use cvr::input;
use cvr::registry::Names;
use cvr::site::coded::CodedFrame;
use cvr::site::expected::Expected;
use cvr::site::host_texture::HostTexture;
use cvr::site::picture::VoxelSource;
use cvr::site::target::Target;
use cvr_codec_tests::mutated::{Mutated, Mutation};
use cvr_core::codec::{BlockFormat, Decoder, Site};
use cvr_core::metrics::AgreementRule;
use cvr_core::render::{DecodedFrame, Filter, Image, Projection, View};
use cvr_core::shader::TextureSampling;
use cvr_core::volume::{
    DenseVolume, Extent, FiniteVolume, FrameIndex, Level, SampleType, Samples, VolumeLayout,
};
use cvr_engine::testing::{lacking, test_device};
use cvr_engine::{BlockFallback, Device, DrawSource, VolumeTexture};
use cvr_raycasting::Raycasting;

use super::runs::run;
use super::scenes::{camera, clipped, draw, mirror, rule, source, textured, view};
use super::subjects::{ODD, codec, encoded, noise, settings};

const KEY: (FrameIndex, Level) = (FrameIndex::FIRST, Level::FULL);

/// A device whose texture units decode BC4. Else a line says that this device's do not.
fn capable(name: &str) -> Option<&'static Device> {
    let device = test_device(name)?;
    let takes = device.capabilities().blocks(BlockFormat::Bc4, 1);
    if let Err(reason) = takes {
        lacking(name, &reason);
    }
    takes.is_ok().then_some(device)
}

fn bc4(volume: &FiniteVolume) -> Box<dyn Decoder> {
    encoded(codec("bc4").as_ref(), &settings(&[]), volume)
}

fn blocks(device: &Device, decoder: &dyn Decoder) -> VolumeTexture {
    let blocks = decoder.block_texture(KEY.0, KEY.1).unwrap();
    VolumeTexture::upload_blocks(device, decoder.layout(), &blocks).unwrap()
}

/// The values that a texture unit decodes from blocks, as a volume.
fn held(device: &Device, decoder: &dyn Decoder) -> Box<dyn Decoder> {
    let layout = VolumeLayout { sample: SampleType::F32, ..decoder.layout().clone() };
    let values = blocks(device, decoder).read(device).unwrap();
    let volume = DenseVolume::new(layout, Samples::F32(values)).unwrap();
    encoded(codec("raw").as_ref(), &settings(&[]), &FiniteVolume::new(volume))
}

/// Uploads as a run would, and returns the record's entries.
fn entered(device: &Device, decoder: &dyn Decoder) -> (Record, Result<(), String>) {
    let frame = Arc::new(DecodedFrame::decode(decoder, FrameIndex::FIRST).unwrap());
    let bc4 = codec("bc4");
    let block = bc4.block(&bc4.info().default_settings());
    let expected = Expected { codec: "bc4", decoder, key: KEY, frame, block };
    let target = Target::Device(device.clone());
    let coded = expected.coded();
    let upload = VoxelSource::prepare(&target, Site::Host, coded, &|| Ok(expected.frame.clone())).unwrap();
    let mut record = Record::default();
    record.enter_preparation(&upload.held.preparation());
    let checked = upload.held.check(&target, &expected, false).unwrap();
    let result = checked.map_or(Ok(()), |checked| record.enter_checked(&checked));
    (record, result)
}

#[test]
fn every_voxel_is_what_the_cpu_decodes_within_the_tolerance() {
    let Some(device) = capable("block_texture::every_voxel") else { return };
    for size in [ODD, [1, 1, 1], [5, 1, 30], [64, 20, 3]] {
        for sample in [SampleType::U8, SampleType::I8, SampleType::U16, SampleType::I16, SampleType::F32] {
            let volume = noise(size, sample);
            let decoder = bc4(&volume);
            let (record, result) = entered(device, decoder.as_ref());
            assert_eq!((result, record.parity_mismatches), (Ok(()), Some(0)), "{sample} {size:?}");
            let [x, y, z] = size.map(u64::from);
            let texture = blocks(device, decoder.as_ref());
            assert_eq!(texture.resident_bytes(), x.div_ceil(4) * y.div_ceil(4) * z * 8, "{size:?}");
        }
    }
}

/// The failing twin: one bit of one index is another level.
#[test]
fn a_wrong_bit_is_caught() {
    let Some(device) = capable("block_texture::wrong_bit") else { return };
    // The highest bit of the first index in the second word, in the middle of the volume.
    let mutation = Mutation::Bit { resource: 0, word: 2 * 4 * 5 * 11 + 2 * 9 + 1, bit: 4 };
    let mutated = Mutated { inner: bc4(&noise(ODD, SampleType::U8)), mutation };
    let (record, result) = entered(device, &mutated);
    let told = result.unwrap_err();
    assert!(
        told.starts_with("what the texture unit decodes is not what the CPU decodes: 1 of 5083"),
        "{told}"
    );
    assert!(
        told.contains("; the first is voxel ")
            && told.contains(" (frame 0), in block ")
            && told.contains(" of 4×4×1 voxels: ")
            && told.ends_with(" apart is allowed"),
        "{told}"
    );
    assert_eq!(record.parity_mismatches, Some(1));
}

/// Oblique and along axes, with whole and cut blocks, with and without a clip box.
fn views() -> Vec<View> {
    use Projection::{Orthographic, Perspective};
    let cameras = [
        camera(30.0, 20.0, Perspective),
        camera(-130.0, -35.0, Orthographic),
        camera(0.0, 0.0, Orthographic),
        camera(180.0, 0.0, Perspective),
        camera(0.0, -90.0, Orthographic),
    ];
    let of = |camera| View { camera, ..view(SampleType::U8, [65, 49], Filter::Linear) };
    cameras.into_iter().map(of).chain([clipped(of(camera(60.0, 10.0, Perspective)))]).collect()
}

#[test]
fn pictures_are_those_of_the_shader_and_of_the_mirror() {
    let Some(device) = capable("block_texture::pictures") else { return };
    for size in [ODD, [24, 20, 16], [30, 9, 14]] {
        let decoder = bc4(&textured(size, [1.0, 1.5, 0.7], SampleType::U8));
        let by_unit = DrawSource::Texture(Arc::new(blocks(device, decoder.as_ref())));
        // Each texture unit interpolates levels in its own way, which the test above checks. So pictures are compared
        // with pictures of its values.
        let held = held(device, decoder.as_ref());
        let by_shader = source(device, Site::Inline, "raw", held.as_ref());
        let mut worst = 0.0_f32;
        for (i, view) in views().into_iter().enumerate() {
            for filter in [Filter::Linear, Filter::Nearest] {
                let view = View { filter, ..view.clone() };
                let (found, filtering) = draw(device, &view, &by_unit);
                assert_eq!(filtering == TextureSampling::Hardware, filter == Filter::Linear);
                let name = format!("{size:?} {filter}, view {i}");
                let mirror = mirror(&view, held.as_ref());
                for expected in [draw(device, &view, &by_shader).0, mirror] {
                    let agreement = AgreementRule::HARDWARE.check(&expected, &found);
                    let agreement = agreement.unwrap_or_else(|e| panic!("{name}: {e}"));
                    assert!(agreement.visible_pixels > 100, "{name}");
                    worst = worst.max(agreement.max_difference);
                }
            }
        }
        println!("{size:?}: pictures differ by {:.2}/255 at most", worst * 255.0);
    }
}

/// The failing twin: each block at the place of its neighbour along x, y or z gives another picture.
#[test]
fn blocks_in_other_places_are_another_picture() {
    let Some(device) = capable("block_texture::other_places") else { return };
    let decoder = bc4(&textured([24, 20, 16], [1.0; 3], SampleType::U8));
    let view = view(SampleType::U8, [65, 49], Filter::Linear);
    let expected = draw(device, &view, &source(device, Site::Inline, "bc4", decoder.as_ref())).0;
    for words in [2, 2 * 6, 2 * 6 * 5] {
        let mut moved = decoder.block_texture(KEY.0, KEY.1).unwrap();
        moved.words.to_mut().rotate_right(words);
        let texture = VolumeTexture::upload_blocks(device, decoder.layout(), &moved).unwrap();
        let found = draw(device, &view, &DrawSource::Texture(Arc::new(texture))).0;
        assert!(AgreementRule::HARDWARE.check(&expected, &found).is_err(), "{words} words");
    }
}

#[test]
fn colours_are_uploaded_as_decoded_and_the_record_says_so() {
    let Some(device) = test_device("block_texture::colours") else { return };
    let extent = Extent::new(9, 6, 4).unwrap();
    let layout = VolumeLayout { channels: 3, ..VolumeLayout::scalar(extent, SampleType::U8) };
    let values = (0..layout.samples()).map(|i| (i * 37 % 251) as u8).collect();
    let decoder = bc4(&FiniteVolume::new(DenseVolume::new(layout, Samples::U8(values)).unwrap()));
    let (record, result) = entered(device, decoder.as_ref());
    assert_eq!((result, record.parity_mismatches), (Ok(()), None));
    let notes = record.notes.unwrap();
    assert!(notes.ends_with("uploaded as decoded by the CPU"), "{notes}");
    // A codec without blocks has nothing to say.
    let raw = encoded(codec("raw").as_ref(), &settings(&[]), &noise(ODD, SampleType::U8));
    assert_eq!(entered(device, raw.as_ref()).0.notes, None);
}

/// A frame drawn by `cvr render` at the site host, its filtering unit, and the reason why blocks were not uploaded; and
/// the same at inline.
fn host_and_inline(
    device: &Device,
    decoder: &dyn Decoder,
    view: &View,
) -> (Image, TextureSampling, Option<String>, Image) {
    let target = Target::Device(device.clone());
    let frame = Arc::new(DecodedFrame::decode(decoder, FrameIndex::FIRST).unwrap());
    let coded = CodedFrame { codec: "bc4", decoder, key: KEY };
    let [host, inline] = [Site::Host, Site::Inline].map(|site| {
        let source = VoxelSource::prepare(&target, site, coded, &|| Ok(frame.clone())).unwrap();
        let picture = target.picture(&Raycasting, view, &source).unwrap();
        let hardware = picture.filtering() == "hardware";
        let filtering = if hardware { TextureSampling::Hardware } else { TextureSampling::Manual };
        (picture.image().unwrap(), filtering, source.held.preparation().remarks.pop())
    });
    (host.0, host.1, host.2, inline.0)
}

/// If texture units decode no blocks, the CPU's decoded frame is uploaded, and record and estimate say so. A capable
/// device is asked not to use blocks.
#[test]
fn without_blocks_the_decoded_frame_is_drawn_and_said() {
    let Some(device) = test_device("block_texture::fallback") else { return };
    let device = device.without_block_textures();
    let decoder = bc4(&textured(ODD, [1.0, 1.5, 0.7], SampleType::U8));
    for filter in [Filter::Nearest, Filter::Linear] {
        let view = view(SampleType::U8, [65, 49], filter);
        let (host, filtering, fallback, inline) = host_and_inline(&device, decoder.as_ref(), &view);
        assert_eq!(fallback, Some(BlockFallback::NotDecoded.to_string()));
        let agreement = rule(filtering).check(&inline, &host).unwrap();
        assert!(agreement.visible_pixels > 500, "{agreement:?}");
    }
    let (record, result) = entered(&device, decoder.as_ref());
    assert_eq!(result, Ok(()));
    assert!(record.notes.unwrap().contains("does not decode them: uploaded as decoded by the CPU"));
    let coded = CodedFrame { codec: "bc4", decoder: decoder.as_ref(), key: KEY };
    let texture = HostTexture::of(&Target::Device(device), coded).unwrap().to_string();
    assert!(texture.contains("does not decode them"), "{texture}");
}

/// This device's results for two volumes that were once drawn black.
#[test]
fn pictures_at_host_are_those_at_inline_whatever_the_device_does_with_blocks() {
    let Some(device) = test_device("block_texture::case") else { return };
    let Some(folder) = std::env::var_os("CVR_DATA").map(PathBuf::from) else {
        println!("skipped block_texture::case: CVR_DATA names no folder beside which there are cases");
        return;
    };
    for file in ["b.npy", "odd.npy"] {
        let path = folder.join("../cases/scenes/38-bc4-gl-host").join(file);
        if !path.exists() {
            println!("skipped block_texture::case: there is no {}", path.display());
            continue;
        }
        let volume = FiniteVolume::new(input::open(&path).unwrap());
        let decoder = bc4(&volume);
        let view =
            View { value_range: volume.range(), ..view(decoder.layout().sample, [64, 64], Filter::Linear) };
        let (host, filtering, fallback, inline) = host_and_inline(device, decoder.as_ref(), &view);
        let takes = device.capabilities().blocks(BlockFormat::Bc4, 1);
        assert_eq!(fallback, takes.err().map(|reason| reason.to_string()), "{file}");
        let agreement = rule(filtering).check(&inline, &host);
        assert!(agreement.unwrap().visible_pixels > 100, "{file}");
    }
}

#[test]
fn memory_is_estimated_by_what_the_device_takes() {
    let Some(device) = capable("block_texture::estimate") else { return };
    let names = Names::new().unwrap();
    let mut trials = Trials::new(&names, Allowance::default());
    let mut bytes = |channels| {
        let extent = Extent::cube(100).unwrap();
        let layout = VolumeLayout { channels, ..VolumeLayout::scalar(extent, SampleType::U8) };
        let settings = codec("bc4").info().default_settings();
        let target = Target::Device(device.clone());
        let trial = trials.of("bc4", &settings, &layout).unwrap().coded("bc4");
        let bytes = cvr::site::of(Site::Host).device_bytes(trial, &target, &layout).unwrap();
        bytes / extent.voxels() as f64
    };
    assert_eq!((bytes(1), bytes(3)), (0.5, 8.0));
}

const CONFIG: &str = r##"
[experiment]
name = "blocks"
seed = 3

[[volume]]
name = "phantom"
generate = "shepp-logan"
dims = [26, 24, 25]
dtype = "u16"

[[codec]]
id = "bc4"

[pipeline]
renderer = ["raycasting"]
site = ["inline", "host", "deferred"]
filter = ["nearest", "linear"]
skipping = [false, true]

[[scene]]
name = "front"
size = [48, 48]
transfer_function = [[0.0, "#00000000"], [8000.0, "#2040a010"], [30000.0, "#ffb04060"], [65535.0, "#ffffffc0"]]
"##;

#[test]
fn a_run_compares_draws_and_counts_the_blocks() {
    let Some(device) = capable("block_texture::run") else { return };
    let folder = tempfile::tempdir().unwrap();
    let names = Names::new().unwrap();
    let outcome = run(&names, CONFIG, &Target::Device(device.clone()), folder.path());
    assert_eq!((outcome.records.len(), outcome.failed()), (12, 0), "{:#?}", outcome.records);
    for r in &outcome.records {
        let name = format!("{} {} {}", r.site, r.filter, r.skipping);
        assert_eq!((r.status, r.parity_mismatches), (Status::Ok, Some(0)), "{name}: {:?}", r.error);
        if r.skipping {
            assert_eq!(r.skipping_mismatches, Some(0), "{name}");
            assert!(r.empty_macrocells.unwrap() > 0.0, "{name}");
        }
        if r.site == "host" {
            // 28 × 24 voxels in blocks, in each of 25 slices.
            assert_eq!(r.resident_bytes, Some(28 * 24 * 25 / 2), "{name}");
            let hardware = if r.filter == "linear" { "hardware" } else { "manual" };
            assert_eq!(r.filtering.as_deref(), Some(hardware), "{name}");
            // Nearest is far from the reference, which is linear.
            let psnr = if r.filter == "linear" { r.image_psnr_db } else { r.codec_image_psnr_db };
            assert!(psnr.unwrap() > 40.0, "{name}: {psnr:?}");
        }
    }
}
