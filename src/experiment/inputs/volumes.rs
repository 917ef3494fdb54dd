//! The volumes of an experiment, loaded and named.

use std::ffi::OsString;
use std::path::PathBuf;

use cvr_core::pipeline::{UnsetVariable, Volume, VolumeSource};
use cvr_core::volume::{BrickSource, DenseVolume, FiniteVolume, StoredType};

use crate::experiment::records::provenance::VolumeProvenance;
use crate::input::{self, Generator, InputError, InputVolume};

/// A volume in memory.
#[derive(Debug)]
pub struct LoadedVolume {
    /// Name in records.
    pub name: String,
    /// The samples, finite.
    pub volume: FiniteVolume,
    /// Number type that its file has.
    pub stored: StoredType,
    /// Where it comes from.
    pub provenance: VolumeProvenance,
}

/// Why a volume cannot be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The path needs an environment variable.
    #[error("volume `{volume}`: {source}; set it to the folder that holds the file: {name}=… cvr …", name = source.name)]
    Unset {
        /// Volume name.
        volume: String,
        /// The variable.
        source: UnsetVariable,
    },
    /// The file or generator failed.
    #[error("volume `{volume}`: {source}")]
    Input {
        /// Volume name.
        volume: String,
        /// Why.
        source: Box<InputError>,
    },
    /// No such generator.
    #[error("volume `{volume}`: no generator `{name}`; there are: {known}")]
    Generator {
        /// Volume name.
        volume: String,
        /// The name.
        name: String,
        /// Known names.
        known: String,
    },
}

/// Loads a volume of an experiment whose seed is `seed`.
///
/// # Errors
/// When a variable in its path is unset, or the file or generator fails.
pub fn load(volume: &Volume, seed: u64) -> Result<LoadedVolume, LoadError> {
    let (input, source) = read(volume, seed)?;
    Ok(LoadedVolume::read(volume.name.clone(), source, input))
}

/// Reads or computes a volume. Also returns its origin: names of files without folders, or generator and seed.
///
/// # Errors
/// As [`load`].
pub fn read(volume: &Volume, seed: u64) -> Result<(InputVolume, String), LoadError> {
    let name = volume.name.clone();
    let (read, source) = match &volume.source {
        VolumeSource::File { files, raw, spacing } => {
            let lookup = |name: &str| -> Option<OsString> { std::env::var_os(name) };
            let paths: Vec<PathBuf> = files
                .iter()
                .map(|path| path.expand(&lookup))
                .collect::<Result<_, _>>()
                .map_err(|source| LoadError::Unset { volume: name.clone(), source })?;
            (input::read(&paths, raw.as_ref(), *spacing), file_names(&paths))
        }
        VolumeSource::Generated { generator, extent, frames, sample } => {
            let kind = Generator::from_name(generator).ok_or_else(|| LoadError::Generator {
                volume: name.clone(),
                name: generator.clone(),
                known: Generator::ALL.map(Generator::name).join(", "),
            })?;
            let dense = input::generate_frames(kind, *extent, *frames, *sample, seed);
            (dense.map(InputVolume::exact), format!("{generator}, seed {seed}"))
        }
    };
    match read {
        Ok(input) => Ok((input, source)),
        Err(source) => Err(LoadError::Input { volume: name, source: Box::new(source) }),
    }
}

/// Names without folders: the first file, and the number of the others.
fn file_names(paths: &[PathBuf]) -> String {
    let first = paths.first().and_then(|p| p.file_name()).unwrap_or_default().to_string_lossy();
    match paths.len() {
        0 | 1 => first.into_owned(),
        n => format!("{first} and {} more", n - 1),
    }
}

impl LoadedVolume {
    /// Names a volume and makes it finite. The hash covers the samples as they were read, little-endian.
    #[must_use]
    pub fn new(name: String, source: String, dense: DenseVolume) -> Self {
        Self::read(name, source, InputVolume::exact(dense))
    }

    fn read(name: String, source: String, read: InputVolume) -> Self {
        let blake3 = blake3::hash(read.volume.samples().as_bytes()).to_hex().to_string();
        let stored = read.stored;
        let volume = read.finite();
        let layout = volume.layout();
        let range = volume.range();
        let provenance = VolumeProvenance {
            name: name.clone(),
            source,
            blake3,
            dims: layout.extent.to_array(),
            dtype: layout.sample.name().to_owned(),
            spacing: layout.spacing,
            range: [f64::from(range.min), f64::from(range.max)],
        };
        Self { name, volume, stored, provenance }
    }
}
