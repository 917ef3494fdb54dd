//! Tests of the room as its users see it: files in a temporary folder, messages without that folder's name.

mod flips;
mod foreign;
mod generators;
mod hostile;
mod hostile_binary;
mod lengths;
mod lies;
mod metaimage_errors;
mod nrrd_errors;
mod promises;
mod real;
mod round_trips;
mod sequences;
mod tiff_files;
mod written;

use std::io::Write as _;
use std::path::PathBuf;

use cvr_core::volume::{DenseVolume, Extent, SampleType, Samples, VolumeLayout};
use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};

use super::{ByteOrder, InputError};

/// A folder that vanishes with the test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes header and data into one file.
    fn write(&self, name: &str, header: &str, data: &[u8]) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, [header.as_bytes(), data].concat()).unwrap();
        path
    }

    /// The message that opening these bytes gives, without the folder.
    fn refusal(&self, name: &str, header: &str, data: &[u8]) -> String {
        self.message(super::open(&self.write(name, header, data)))
    }

    fn message(&self, result: Result<DenseVolume, InputError>) -> String {
        let folder = format!("{}/", self.0.path().display());
        result.expect_err("must be refused").to_string().replace(&folder, "")
    }
}

/// 3×4×2 voxels that reach both ends of their type.
fn small(sample: SampleType, spacing: [f64; 3]) -> DenseVolume {
    let n = 24_i32;
    let samples = match sample {
        SampleType::U8 => Samples::U8((0..n).map(|i| (i * 11) as u8).collect()),
        SampleType::I8 => Samples::I8((0..n).map(|i| (i * 11 - 128) as i8).collect()),
        SampleType::U16 => Samples::U16((0..n).map(|i| (i * 2849) as u16).collect()),
        SampleType::I16 => Samples::I16((0..n).map(|i| (i * 2849 - 32768) as i16).collect()),
        SampleType::F32 => Samples::F32(
            (0..n)
                .map(|i| [1.5e-40, -0.0, f32::INFINITY, f32::MAX, 0.1 * i as f32][i as usize % 5])
                .collect(),
        ),
        other => panic!("no test volume of {other}"),
    };
    let extent = Extent::new(3, 4, 2).unwrap();
    DenseVolume::new(VolumeLayout { spacing, ..VolumeLayout::scalar(extent, sample) }, samples).unwrap()
}

/// The samples as a file of that byte order holds them.
fn stored(volume: &DenseVolume, order: ByteOrder) -> Vec<u8> {
    let mut bytes = volume.samples().as_bytes().to_vec();
    if order != ByteOrder::NATIVE {
        let size = volume.samples().sample_type().bytes();
        bytes.chunks_exact_mut(size).for_each(<[u8]>::reverse);
    }
    bytes
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = GzEncoder::new(Vec::new(), Compression::default());
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut out = ZlibEncoder::new(Vec::new(), Compression::default());
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}
