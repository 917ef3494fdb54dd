//! Real volumes, against facts computed from the files by other software.

use std::path::PathBuf;

use cvr_core::volume::{BrickSource as _, DenseVolume, Extent, SampleType, Samples, StoredType, ValueRange};

use crate::input::{RawLayout, open, open_raw};

/// The folder of real volumes; a printed line without it.
fn file(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("CVR_DATA");
    if folder.is_none() {
        println!("skipped: {name} is not read, because CVR_DATA names no folder of real volumes");
    }
    folder.map(|f| PathBuf::from(f).join(name))
}

fn check(volume: &DenseVolume, dims: [u32; 3], sample: SampleType, spacing: [f64; 3], range: (f32, f32)) {
    let layout = volume.layout();
    assert_eq!((layout.extent.to_array(), layout.sample, layout.spacing), (dims, sample, spacing));
    let (min, max) = range;
    assert_eq!(volume.value_range(), ValueRange::of([min, max]));
}

fn voxel(volume: &DenseVolume, p: [u32; 3]) -> f32 {
    volume.samples().get(volume.layout().extent.index(p))
}

#[test]
fn bonsai() {
    let Some(path) = file("bonsai.nrrd") else { return };
    let volume = open(&path).unwrap();
    check(&volume, [256; 3], SampleType::U8, [1.0; 3], (0.0, 255.0));
    let Samples::U8(v) = volume.samples() else { panic!("checked above") };
    assert_eq!(v.iter().map(|&s| u64::from(s)).sum::<u64>(), 230_038_784);
    assert_eq!((voxel(&volume, [120, 100, 128]), voxel(&volume, [128, 130, 200])), (133.0, 38.0));
}

#[test]
fn mr_vs() {
    let Some(path) = file("mr_vs.mhd") else { return };
    let volume = open(&path).unwrap();
    check(&volume, [352, 416, 120], SampleType::U16, [0.410156, 0.410156, 1.5], (0.0, 1826.0));
    let Samples::U16(v) = volume.samples() else { panic!("checked above") };
    assert_eq!(v.iter().map(|&s| u64::from(s)).sum::<u64>(), 5_352_720_779);
    assert_eq!((voxel(&volume, [150, 200, 60]), voxel(&volume, [20, 300, 10])), (549.0, 124.0));
}

#[test]
fn lidc_chest() {
    let Some(path) = file("lidc_chest.mha") else { return };
    let volume = open(&path).unwrap();
    // The header's digits, which miss 1.40625 and 2.5 by some rounding errors.
    let spacing = [1.4062499999999947, 1.406249999999991, 2.499999999999981];
    check(&volume, [256, 256, 133], SampleType::U8, spacing, (0.0, 255.0));
    let Samples::U8(v) = volume.samples() else { panic!("checked above") };
    assert_eq!(v.iter().map(|&s| u64::from(s)).sum::<u64>(), 61_489_178);
}

#[test]
fn vorticity() {
    let Some(path) = file("vorticity.128_128_41") else { return };
    let spec = RawLayout::new(Extent::new(128, 128, 41).unwrap(), StoredType::F32);
    let volume = open_raw(&path, &spec).unwrap();
    check(&volume, [128, 128, 41], SampleType::F32, [1.0; 3], (-0.00020433865, 0.00022811173));
    assert_eq!(voxel(&volume, [100, 64, 20]), 2.0769743e-5);
    let Samples::F32(v) = volume.samples() else { panic!("checked above") };
    assert_eq!(v.iter().map(|s| u64::from(s.to_bits())).sum::<u64>(), 1_353_387_162_485_029);
}
