//! The volumes of an experiment, loaded and named.

use std::path::PathBuf;

use cvr_core::pipeline::{UnsetVariable, Volume, VolumeSource};
use cvr_core::volume::{BrickSource, DenseVolume, FiniteVolume};

use super::provenance::VolumeProvenance;
use crate::input::{self, Generator, InputError};

/// A volume in memory.
#[derive(Debug)]
pub struct LoadedVolume {
    /// Name in records.
    pub name: String,
    /// The samples, finite.
    pub volume: FiniteVolume,
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
    let name = volume.name.clone();
    let (dense, source) = match &volume.source {
        VolumeSource::File { path, raw } => {
            let path = path
                .expand(&|name| std::env::var_os(name))
                .map_err(|source| LoadError::Unset { volume: name.clone(), source })?;
            let file = PathBuf::from(&path);
            let read = match raw {
                Some(layout) => input::open_raw(&file, layout),
                None => input::open(&file),
            };
            (read, file.file_name().unwrap_or_default().to_string_lossy().into_owned())
        }
        VolumeSource::Generated { generator, extent, sample } => {
            let kind = Generator::from_name(generator).ok_or_else(|| LoadError::Generator {
                volume: name.clone(),
                name: generator.clone(),
                known: Generator::ALL.map(Generator::name).join(", "),
            })?;
            (input::generate(kind, *extent, *sample, seed), format!("{generator}, seed {seed}"))
        }
    };
    let dense =
        dense.map_err(|source| LoadError::Input { volume: name.clone(), source: Box::new(source) })?;
    Ok(LoadedVolume::new(name, source, dense))
}

impl LoadedVolume {
    /// Names a volume and makes it finite. The hash is that of the samples as they were read, little-endian.
    #[must_use]
    pub fn new(name: String, source: String, dense: DenseVolume) -> Self {
        let blake3 = blake3::hash(dense.samples().as_bytes()).to_hex().to_string();
        let volume = FiniteVolume::new(dense);
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
        Self { name, volume, provenance }
    }
}
