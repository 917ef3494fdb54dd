//! A volume on the command line: files, and the layout of headerless ones.

use std::path::{Path, PathBuf};

use clap::Args;
use cvr_core::file::is_standard_output;
use cvr_core::pipeline::{ByteOrder, FilePath, RawLayout, Volume, VolumeSource};
use cvr_core::volume::{Extent, StoredType};

use crate::exit::BadInput;
use crate::experiment::inputs::volumes::{LoadedVolume, load, read};
use crate::input::{InputVolume, found};

/// Layout of a headerless volume file.
#[derive(Debug, Args)]
#[command(next_help_heading = "Headerless volume files")]
pub struct RawArgs {
    /// Voxels along x, y, z of a headerless file, as 128x128x41.
    #[arg(long, value_parser = extent, requires = "dtype")]
    dims: Option<Extent>,
    /// Number type of its samples: u8, i8, u16, i16, u32, i32, u64, i64, f32, f64.
    #[arg(long, value_parser = stored, requires = "dims")]
    dtype: Option<StoredType>,
    /// Time steps in it, one after the other [default: 1].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..), requires = "dims")]
    frames: Option<u32>,
    /// Values per voxel, side by side: 1 or 3 [default: 1].
    #[arg(long, value_parser = channels, requires = "dims")]
    channels: Option<u32>,
    /// Its byte order: little or big.
    #[arg(long, value_parser = byte_order, requires = "dims")]
    byte_order: Option<ByteOrder>,
    /// Spacing along x, y, z, as 0.41,0.41,1.5; replaces that of any file.
    #[arg(long, value_parser = spacing)]
    spacing: Option<[f64; 3]>,
    /// Bytes before its first sample.
    #[arg(long, requires = "dims")]
    skip_bytes: Option<u64>,
}

impl RawArgs {
    /// The volume in these files, named after the first. Frames of several files follow one another.
    pub fn volume(&self, paths: &[PathBuf]) -> Result<Volume, BadInput> {
        let raw = self.dims.zip(self.dtype).map(|(extent, stored)| RawLayout {
            extent,
            channels: self.channels.unwrap_or(1),
            frames: self.frames.unwrap_or(1),
            stored,
            byte_order: self.byte_order.unwrap_or_default(),
            spacing: self.spacing.unwrap_or([1.0; 3]),
            skip_bytes: self.skip_bytes.unwrap_or(0),
        });
        let name = paths.first().map(|p| volume_name(p)).unwrap_or_default();
        let literal = |path: &PathBuf| FilePath::literal(&path.display().to_string());
        let files = paths.iter().map(literal).collect::<Result<_, _>>()?;
        let spacing = self.spacing.filter(|_| raw.is_none());
        Ok(Volume { name, source: VolumeSource::File { files, raw, spacing } })
    }

    /// Loads a file, or all matches of a pattern.
    pub fn load(&self, path: &Path) -> Result<LoadedVolume, BadInput> {
        self.load_all(&[path.to_owned()])
    }

    /// Loads files as the frames of one volume.
    pub fn load_all(&self, paths: &[PathBuf]) -> Result<LoadedVolume, BadInput> {
        Ok(load(&self.volume(paths)?, 0)?)
    }

    /// The files and folders of these paths.
    pub fn found(&self, paths: &[PathBuf]) -> Result<Vec<PathBuf>, BadInput> {
        Ok(found(paths, self.dims.is_some())?)
    }

    /// As [`Self::load_all`], before unusable samples are replaced.
    pub fn read_all(&self, paths: &[PathBuf]) -> Result<InputVolume, BadInput> {
        Ok(read(&self.volume(paths)?, 0)?.0)
    }
}

/// The stem of a file's name without wildcards. For a pattern like `*.raw` it is the folder's name.
fn volume_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let stem = stem.strip_suffix(".nii").unwrap_or(&stem);
    let name: String = stem.chars().filter(|c| !"*?[]!".contains(*c)).collect();
    if name == stem {
        return name;
    }
    let name = name.trim_matches(|c: char| "._- ".contains(c));
    let parent =
        || path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned();
    let name = if name.is_empty() { parent() } else { name.to_owned() };
    if name.is_empty() { "sequence".to_owned() } else { name }
}

/// `128x128x41`.
fn extent(text: &str) -> Result<Extent, String> {
    let help = || format!("`{text}`: write three numbers as 128x128x41");
    let axes: Vec<u32> = text.split('x').map(str::parse).collect::<Result<_, _>>().map_err(|_| help())?;
    let [x, y, z] = axes[..] else { return Err(help()) };
    Extent::new(x, y, z).map_err(|e| e.to_string())
}

fn stored(text: &str) -> Result<StoredType, String> {
    let known = StoredType::ALL.map(StoredType::name).join(", ");
    StoredType::from_name(text).ok_or_else(|| format!("`{text}`: one of {known}"))
}

fn channels(text: &str) -> Result<u32, String> {
    match text {
        "1" => Ok(1),
        "3" => Ok(3),
        _ => Err(format!("`{text}`: 1 (scalar) or 3 (RGB)")),
    }
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

/// The folder of an output file must exist, and the file must differ from the input. Checked before a long run starts.
pub fn check_output(path: &Path, input: &Path) -> Result<(), BadInput> {
    if path.canonicalize().is_ok_and(|path| input.canonicalize().is_ok_and(|input| input == path)) {
        return Err(BadInput(format!("{} is the input: write to another file", path.display())));
    }
    if is_standard_output(path) {
        crate::say::on_standard_error();
    }
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() && !parent.is_dir() => {
            Err(BadInput(format!("{}: the folder {} does not exist", path.display(), parent.display())))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volumes_are_named_after_what_is_left_of_a_pattern() {
        for (path, name) in [
            ("a/head.nrrd", "head"),
            ("pcasl.nii.gz", "pcasl"),
            ("viscous/step*.raw", "step"),
            ("viscous/step_[0-9]?.raw", "step_0-9"),
            ("viscous/*.raw", "viscous"),
            ("*.raw", "sequence"),
            ("a-b*", "a-b"),
        ] {
            assert_eq!(volume_name(Path::new(path)), name);
        }
    }
}
