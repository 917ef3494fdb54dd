//! The real volumes by name, and processor time for figures.

use std::path::{Path, PathBuf};
use std::time::Duration;

use cvr_core::volume::{DenseVolume, Extent, FiniteVolume, SampleType, Samples, VolumeLayout};
use flate2::read::{MultiGzDecoder, ZlibDecoder};
use rustix::time::{ClockId, clock_gettime};

/// The folder that `CVR_DATA` names. Without it, a line is printed and the test ends.
#[must_use]
pub fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("CVR_DATA").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: CVR_DATA names no folder of real volumes");
    }
    folder
}

fn volume(size: [u32; 3], channels: u32, frames: u32, sample: SampleType, bytes: &[u8]) -> FiniteVolume {
    let extent = Extent::try_from(size).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, sample) };
    let samples = Samples::from_bytes(sample, bytes, false).unwrap();
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

fn file(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap()
}

fn all_of(mut reader: impl std::io::Read) -> Vec<u8> {
    let mut bytes = Vec::new();
    reader.read_to_end(&mut bytes).unwrap();
    bytes
}

/// Behind the text that ends a header.
fn behind<'a>(bytes: &'a [u8], marker: &[u8]) -> &'a [u8] {
    let at = bytes.windows(marker.len()).position(|w| w == marker).unwrap();
    &bytes[at + marker.len()..]
}

/// The samples of a little-endian NIfTI-1 file. The float at byte 108 is their position.
fn nifti(folder: &Path, name: &str) -> Vec<u8> {
    let mut bytes = all_of(MultiGzDecoder::new(&file(folder, name)[..]));
    let first = f32::from_le_bytes(bytes[108..112].try_into().unwrap());
    bytes.split_off(first as usize)
}

/// Names of all volumes.
pub const NAMES: [&str; 7] =
    ["bonsai", "mr_vs", "lidc_chest", "vorticity", "viscous_fingers", "pcasl", "dti_rgb"];

/// A volume by its name.
#[must_use]
pub fn volume_of(folder: &Path, name: &str) -> FiniteVolume {
    match name {
        "bonsai" => {
            let packed = file(folder, "bonsai.nrrd");
            let bytes = all_of(MultiGzDecoder::new(behind(&packed, b"\n\n")));
            volume([256; 3], 1, 1, SampleType::U8, &bytes)
        }
        "mr_vs" => {
            let bytes = all_of(ZlibDecoder::new(&file(folder, "mr_vs.zraw")[..]));
            volume([352, 416, 120], 1, 1, SampleType::U16, &bytes)
        }
        "lidc_chest" => {
            let packed = file(folder, "lidc_chest.mha");
            let bytes = all_of(ZlibDecoder::new(behind(&packed, b"ElementDataFile = LOCAL\n")));
            volume([256, 256, 133], 1, 1, SampleType::U8, &bytes)
        }
        "vorticity" => volume([128, 128, 41], 1, 1, SampleType::F32, &file(folder, "vorticity.128_128_41")),
        "viscous_fingers" => {
            let steps = std::fs::read_dir(folder.join("viscous_fingers")).unwrap();
            let mut steps: Vec<_> = steps.map(|e| e.unwrap().path()).collect();
            steps.sort();
            let bytes: Vec<u8> = steps.iter().flat_map(|step| std::fs::read(step).unwrap()).collect();
            volume([64; 3], 1, 24, SampleType::F32, &bytes)
        }
        "pcasl" => volume([52, 68, 20], 1, 10, SampleType::F32, &nifti(folder, "pcasl.nii.gz")),
        "dti_rgb" => volume([96, 96, 60], 3, 1, SampleType::U8, &nifti(folder, "example_rgb.nii.gz")),
        other => panic!("no volume {other}"),
    }
}

/// CPU time of this process, all threads together.
#[must_use]
pub fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec.unsigned_abs() as u32)
}
