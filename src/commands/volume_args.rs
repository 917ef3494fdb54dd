//! A volume on the command line: a file, with the layout of a headerless one.

use std::path::Path;

use clap::Args;
use cvr_core::pipeline::{ByteOrder, FilePath, RawLayout, Volume, VolumeSource};
use cvr_core::volume::{Extent, SampleType};

use crate::exit::BadInput;
use crate::experiment::volumes::{LoadedVolume, load};

/// Layout of a headerless volume file.
#[derive(Debug, Args)]
#[command(next_help_heading = "Headerless volume files")]
pub struct RawArgs {
    /// Voxels along x, y, z of a headerless file, as 128x128x41.
    #[arg(long, value_parser = extent, requires = "dtype")]
    dims: Option<Extent>,
    /// Number type of its samples: u8, i8, u16, i16, f32.
    #[arg(long, value_parser = sample, requires = "dims")]
    dtype: Option<SampleType>,
    /// Its byte order: little or big.
    #[arg(long, value_parser = byte_order, requires = "dims")]
    byte_order: Option<ByteOrder>,
    /// Its spacing along x, y, z, as 0.41,0.41,1.5.
    #[arg(long, value_parser = spacing, requires = "dims")]
    spacing: Option<[f64; 3]>,
    /// Bytes in front of its first sample.
    #[arg(long, requires = "dims")]
    skip_bytes: Option<u64>,
}

impl RawArgs {
    /// The volume in a file, named after it.
    pub fn volume(&self, path: &Path) -> Result<Volume, BadInput> {
        let raw = self.dims.zip(self.dtype).map(|(extent, sample)| RawLayout {
            extent,
            sample,
            byte_order: self.byte_order.unwrap_or_default(),
            spacing: self.spacing.unwrap_or([1.0; 3]),
            skip_bytes: self.skip_bytes.unwrap_or(0),
        });
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let path = FilePath::literal(&path.display().to_string())?;
        Ok(Volume { name, source: VolumeSource::File { path, raw } })
    }

    /// Loads a file.
    pub fn load(&self, path: &Path) -> Result<LoadedVolume, BadInput> {
        Ok(load(&self.volume(path)?, 0)?)
    }
}

/// `128x128x41`.
fn extent(text: &str) -> Result<Extent, String> {
    let help = || format!("`{text}`: write three numbers as 128x128x41");
    let axes: Vec<u32> = text.split('x').map(str::parse).collect::<Result<_, _>>().map_err(|_| help())?;
    let [x, y, z] = axes[..] else { return Err(help()) };
    Extent::new(x, y, z).map_err(|e| e.to_string())
}

fn sample(text: &str) -> Result<SampleType, String> {
    let known = SampleType::ALL.map(SampleType::name).join(", ");
    SampleType::from_name(text).ok_or_else(|| format!("`{text}`: one of {known}"))
}

fn byte_order(text: &str) -> Result<ByteOrder, String> {
    let mut orders = [ByteOrder::Little, ByteOrder::Big].into_iter();
    orders.find(|o| o.name() == text).ok_or_else(|| format!("`{text}`: little or big"))
}

fn spacing(text: &str) -> Result<[f64; 3], String> {
    let help = || format!("`{text}`: write three lengths as 0.41,0.41,1.5");
    let axes: Vec<f64> =
        text.split(',').map(|a| a.trim().parse()).collect::<Result<_, _>>().map_err(|_| help())?;
    axes.try_into().map_err(|_| help())
}

/// Whether a path names an encoded volume.
pub fn is_container(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("cvr"))
}

/// The folder that a file is to stand in must exist, and the file be another than the one that is read; a message
/// beforehand beats one after a long run.
pub fn check_output(path: &Path, input: &Path) -> Result<(), BadInput> {
    if path.canonicalize().is_ok_and(|path| input.canonicalize().is_ok_and(|input| input == path)) {
        return Err(BadInput(format!("{} is the input: write to another file", path.display())));
    }
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() && !parent.is_dir() => {
            Err(BadInput(format!("{}: the folder {} does not exist", path.display(), parent.display())))
        }
        _ => Ok(()),
    }
}
