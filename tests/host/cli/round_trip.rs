//! Encode, inspect, decode, draw.

use cvr::input::{Generator, open};
use cvr_core::volume::{BrickSource as _, DenseVolume, SampleType};

use super::super::folder::Folder;
use super::super::volumes::{computed, spaced};

fn volume(sample: SampleType) -> DenseVolume {
    spaced(&computed(Generator::Turbulence, [13, 17, 11], sample), [0.5, 0.5, 1.25])
}

/// The number before or after a word in the output of `cvr info`.
fn told(info: &str, word: &str) -> Option<f64> {
    info.lines()
        .find_map(|l| l.strip_prefix(word))
        .and_then(|rest| rest.split_whitespace().rev().find_map(|w| w.parse().ok()))
}

/// Largest difference of two volumes, and whether their layouts are equal.
fn compared(a: &DenseVolume, b: &DenseVolume) -> (f64, bool) {
    let samples = 0..a.samples().len().max(b.samples().len());
    let difference = |i| f64::from(a.samples().get(i)) - f64::from(b.samples().get(i));
    (samples.map(|i| difference(i).abs()).fold(0.0, f64::max), a.layout() == b.layout())
}

#[test]
fn raw_is_exact_for_every_sample_type() {
    for sample in SampleType::ALL {
        let folder = Folder::new();
        folder.volume("v.nrrd", &volume(sample));
        let said = folder.cvr(&["encode", "v.nrrd", "v.cvr", "--codec", "raw"]).exits(0).stdout;
        assert!(said.contains(&format!("{} bytes", folder.read("v.cvr").len())), "{said}");
        let info = folder.cvr(&["info", "v.cvr"]).exits(0).stdout;
        assert!(info.contains("13×17×11") && info.contains(sample.name()), "{info}");
        assert!(info.contains("codec      raw") && told(&info, "bound") == Some(0.0), "{info}");
        folder.cvr(&["decode", "v.cvr", "back.nrrd"]).exits(0);
        assert_eq!(open(&folder.path("back.nrrd")).unwrap(), volume(sample), "{sample}");
        assert_eq!(folder.names(), ["back.nrrd", "v.cvr", "v.nrrd"]);
    }
}

#[test]
fn s3dc_keeps_the_bound_that_info_tells() {
    for sample in SampleType::ALL {
        for (block, bits) in [("4", "2"), ("3x5x2", "4"), ("16", "1")] {
            let folder = Folder::new();
            folder.volume("v.nrrd", &volume(sample));
            let (block, bits) = (format!("block={block}"), format!("index_bits={bits}"));
            folder
                .cvr(&["encode", "v.nrrd", "v.cvr", "--codec", "s3dc", "--set", &block, "--set", &bits])
                .exits(0);
            let info = folder.cvr(&["info", "v.cvr"]).exits(0).stdout;
            assert!(info.contains(&bits), "{info}");
            let bound = told(&info, "bound").unwrap();
            folder.cvr(&["decode", "v.cvr", "back.nrrd"]).exits(0);
            let back = open(&folder.path("back.nrrd")).unwrap();
            let (error, same_layout) = compared(&back, &volume(sample));
            assert!(same_layout && error <= bound, "{sample} {block} {bits}: {error} of {bound}");
            assert!(error > 0.0, "{sample} {block} {bits}: a lossy codec that loses nothing is not measured");

            folder.cvr(&["decode", "v.cvr", "float.nrrd", "--float"]).exits(0);
            let float = open(&folder.path("float.nrrd")).unwrap();
            assert_eq!(float.layout().sample, SampleType::F32);
            assert!(compared(&float, &volume(sample)).0 <= bound.max(bound + 0.5));
        }
    }
}

#[test]
fn the_comparison_sees_one_sample_and_the_layout() {
    let original = volume(SampleType::I16);
    let cvr_core::volume::Samples::I16(mut samples) = original.samples().clone() else { panic!("i16") };
    samples[1000] += 1;
    let changed =
        DenseVolume::new(original.layout().clone(), cvr_core::volume::Samples::I16(samples)).unwrap();
    assert_eq!(compared(&original, &changed), (1.0, true));
    assert_eq!(compared(&original, &spaced(&original, [1.0; 3])), (0.0, false));
}

#[test]
fn a_container_draws_what_its_volume_draws() {
    let folder = Folder::new();
    folder.volume("v.nrrd", &volume(SampleType::U16));
    folder.cvr(&["encode", "v.nrrd", "v.cvr", "--codec", "raw"]).exits(0);
    let draw = |file: &str, out: &str, more: &[&str]| {
        let arguments = [&["render", file, out, "--device", "cpu", "--size", "24x16"][..], more].concat();
        folder.cvr(&arguments).exits(0);
        let picture = image::open(folder.path(out)).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (24, 16));
        assert!(picture.pixels().any(|p| p.0 != [0; 3]), "{out} is blank");
        picture
    };
    let original = draw("v.nrrd", "a.png", &[]);
    assert_eq!(original, draw("v.cvr", "b.png", &[]));
    assert_eq!(original, draw("v.cvr", "c.png", &["--site", "host"]));
    assert_eq!(original, draw("v.cvr", "c.png", &["--site", "deferred"]));
    let slices = ["--renderer", "slicing,geometry=axis", "--site"];
    let [deferred, ring] =
        ["deferred", "ring"].map(|site| draw("v.cvr", "e.png", &[&slices[..], &[site]].concat()));
    assert_eq!(deferred, ring, "the mirror has no ring: it draws from the whole frame");
    for other in [&["--azimuth", "-60"][..], &["--filter", "nearest"], &["--orthographic"], &["--zoom", "2"]]
    {
        assert_ne!(original, draw("v.cvr", "d.png", other), "{other:?} changes nothing");
    }
}

#[test]
fn replaced_samples_are_told() {
    let folder = Folder::new();
    folder.write("v.raw", [1.0_f32, f32::NAN, f32::INFINITY, 1e-40].map(f32::to_le_bytes).concat());
    let layout = ["--dims", "4x1x1", "--dtype", "f32"];
    let info = folder.cvr(&[&["info", "v.raw"][..], &layout].concat()).exits(0).stdout;
    assert!(info.contains("1 NaN, 1 infinite, 1 subnormal"), "{info}");
    let arguments = [&["encode", "v.raw", "v.cvr", "--codec", "raw"][..], &layout].concat();
    let said = folder.cvr(&arguments).exits(0).stdout;
    assert!(said.contains("3 samples were no usable numbers"), "{said}");
}
