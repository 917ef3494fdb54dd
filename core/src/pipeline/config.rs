//! A checked experiment, apart from its scenes.

use super::{FilePath, Scene};
use crate::codec::{SettingValue, Settings, Site};
use crate::render::Filter;
use crate::volume::{Extent, SampleType, StoredType};

/// An experiment: volumes × codecs and their settings × scenes × renderers × sites × filters ×
/// skipping × stages × resolutions.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Name, for reports and folders.
    pub name: String,
    /// Seed of all random numbers. Default 0.
    pub seed: u64,
    /// Most cells, refused combinations included; default [`Experiment::MAX_CELLS`].
    pub max_cells: u64,
    /// Megabytes (10⁶ bytes) of decoded frames to keep of each stream with predicted frames. Default
    /// [`FrameStore::DEFAULT_MB`](crate::codec::FrameStore::DEFAULT_MB). It changes how often frames are decoded, but
    /// no result.
    pub decoded_frames_mb: u32,
    /// At least one. Names differ even in lower case, because they become file names.
    pub volumes: Vec<Volume>,
    /// At least one, in the order of the file. A codec may be listed several times.
    pub codecs: Vec<CodecSweep>,
    /// How pictures are made.
    pub pipeline: PipelineAxes,
    /// At least one. Names differ even in lower case.
    pub scenes: Vec<Scene>,
    /// Notes of the parser for the author of the configuration, one sentence each.
    pub notes: Vec<String>,
}

/// A volume and its source.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Name in records and file names.
    pub name: String,
    /// Where it comes from.
    pub source: VolumeSource,
}

/// Source of a volume.
#[derive(Clone, Debug, PartialEq)]
pub enum VolumeSource {
    /// Files.
    File {
        /// At least one: a file, a folder of slices, or a pattern such as `step*.raw`. The frames of all files, and of
        /// all matches of a pattern, follow one another.
        files: Vec<FilePath>,
        /// Layout of each file, if the files have no header.
        raw: Option<RawLayout>,
        /// Distance between voxel centres along x, y, z. Positive. `None`: the files' own. If `raw` is set, it holds
        /// the spacing instead.
        spacing: Option<[f64; 3]>,
    },
    /// A generator of the application.
    Generated {
        /// The generator.
        generator: String,
        /// Size; default 64 × 64 × 64 voxels.
        extent: Extent,
        /// Time steps, at least 1; default 1.
        frames: u32,
        /// Number type; default [`SampleType::U8`].
        sample: SampleType,
    },
}

impl VolumeSource {
    /// One file (or folder, or pattern) that describes itself.
    #[must_use]
    pub fn file(path: FilePath) -> Self {
        Self::File { files: vec![path], raw: None, spacing: None }
    }
}

/// Layout of a headerless file: contiguous samples, channels interleaved, x fastest, frame after frame.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RawLayout {
    /// Size in voxels.
    pub extent: Extent,
    /// Values per voxel: 1 or 3; default 1.
    pub channels: u32,
    /// Time steps, at least 1; default 1.
    pub frames: u32,
    /// Number type.
    pub stored: StoredType,
    /// Byte order of numbers with several bytes. Default little-endian.
    pub byte_order: ByteOrder,
    /// Distance between voxel centres along x, y, z; positive; default 1.
    pub spacing: [f64; 3],
    /// Bytes before the first sample; default 0.
    pub skip_bytes: u64,
}

impl RawLayout {
    /// One frame of little-endian scalars with unit spacing, from the first byte of the file.
    #[must_use]
    pub const fn new(extent: Extent, stored: StoredType) -> Self {
        let byte_order = ByteOrder::Little;
        Self { extent, channels: 1, frames: 1, stored, byte_order, spacing: [1.0; 3], skip_bytes: 0 }
    }
}

/// Byte order of a number.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum ByteOrder {
    /// Lowest byte first.
    #[default]
    Little,
    /// Highest byte first.
    Big,
}

impl ByteOrder {
    /// The byte order of this machine.
    pub const NATIVE: Self = if cfg!(target_endian = "big") { Self::Big } else { Self::Little };

    /// Name used in TOML.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Little => "little",
            Self::Big => "big",
        }
    }
}

/// A codec, and the values of its settings to try.
#[derive(Clone, Debug, PartialEq)]
pub struct CodecSweep {
    /// Codec id.
    pub id: String,
    /// The settings in the configuration, in its order. The first one varies slowest. All others keep their defaults.
    pub sweeps: Vec<Sweep>,
}

/// The values of one setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Setting.
    pub name: String,
    /// At least one value, in canonical form, in the order of the configuration.
    pub values: Vec<SettingValue>,
}

impl Sweep {
    /// Number of [`Sweep::combinations`]. It makes none.
    #[must_use]
    pub fn count(sweeps: &[Self]) -> u128 {
        sweeps.iter().fold(1, |count: u128, sweep| count.saturating_mul(sweep.values.len() as u128))
    }

    /// Every combination of the values. The first sweep varies slowest. Without sweeps, one empty combination.
    #[must_use]
    pub fn combinations(sweeps: &[Self]) -> Vec<Settings> {
        sweeps.iter().fold(vec![Settings::default()], |combinations, Self { name, values }| {
            let with = |settings: &Settings, value: &SettingValue| {
                let mut settings = settings.clone();
                settings.set(name, value.clone());
                settings
            };
            combinations.iter().flat_map(|s| values.iter().map(move |v| with(s, v))).collect()
        })
    }
}

/// How pictures are made. Each list has at least one member, and none twice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PipelineAxes {
    /// Labels of renderers ([`crate::render::RendererInfo::label`]): ids, with the settings that differ from the
    /// defaults.
    pub renderers: Vec<String>,
    /// Decode sites.
    pub sites: Vec<Site>,
    /// Filters.
    pub filters: Vec<Filter>,
    /// Whether empty macrocells are skipped; default only `false`.
    pub skipping: Vec<bool>,
    /// Numbers of stages to decode, each at least 1. `None`, the default, means all.
    pub stages: Vec<Option<u8>>,
    /// Resolutions that are decoded; default only 0, the full one.
    pub resolutions: Vec<u8>,
}

/// No scene applies to a volume.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "no scene applies to volume `{volume}`: add a `[[scene]]` without `volumes`, or name the volume in one"
)]
pub struct NoScene {
    /// The volume.
    pub volume: String,
}

/// An experiment is larger than it may be.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the experiment has {cells} cells, and {allowed} are allowed: shorten a list, or give `max_cells` of `[experiment]` a \
     larger number (`--set experiment.max_cells=N`)"
)]
pub struct TooManyCells {
    /// Cells and refused combinations.
    pub cells: u128,
    /// [`Experiment::max_cells`].
    pub allowed: u64,
}

impl Experiment {
    /// Largest number of cells by default. A cell takes a second or more to run, and some kilobytes of memory in the
    /// list.
    pub const MAX_CELLS: u64 = 100_000;

    /// Cells and refused combinations together, found without making one.
    #[must_use]
    pub fn combinations(&self) -> u128 {
        let PipelineAxes { renderers, sites, filters, skipping, stages, resolutions } = &self.pipeline;
        let levels = [stages.len(), resolutions.len()];
        let axes = [renderers.len(), sites.len(), filters.len(), skipping.len()].into_iter().chain(levels);
        let settings = self.codecs.iter().map(|codec| Sweep::count(&codec.sweeps));
        let settings = settings.fold(0, u128::saturating_add);
        let scenes: u128 = self.volumes.iter().map(|v| self.scenes_of(&v.name).count() as u128).sum();
        axes.fold(scenes.saturating_mul(settings), |n, axis| n.saturating_mul(axis as u128))
    }

    /// Checks the number of cells against the limit, before any cell is made.
    ///
    /// # Errors
    /// When there are more.
    pub fn check_size(&self) -> Result<(), TooManyCells> {
        let (cells, allowed) = (self.combinations(), self.max_cells);
        if cells > u128::from(allowed) { Err(TooManyCells { cells, allowed }) } else { Ok(()) }
    }

    /// The volume of this name.
    #[must_use]
    pub fn volume(&self, name: &str) -> Option<&Volume> {
        self.volumes.iter().find(|v| v.name == name)
    }

    /// The scene of this name.
    #[must_use]
    pub fn scene(&self, name: &str) -> Option<&Scene> {
        self.scenes.iter().find(|s| s.name == name)
    }

    /// The scenes of a volume: those that name it. If none does, those without a list of volumes.
    pub fn scenes_of<'a>(&'a self, volume: &'a str) -> impl Iterator<Item = &'a Scene> {
        let names = move |s: &&Scene| s.volumes.iter().flatten().any(|v| v == volume);
        let named = self.scenes.iter().any(|s| names(&s));
        self.scenes.iter().filter(move |s| if named { names(s) } else { s.volumes.is_none() })
    }

    /// Replaces the volumes, as `--volume` does. Scenes for volumes that are gone are not used.
    ///
    /// # Errors
    /// When no scene applies to one of them; the experiment is then unchanged.
    pub fn replace_volumes(&mut self, volumes: Vec<Volume>) -> Result<(), NoScene> {
        match volumes.iter().find(|v| self.scenes_of(&v.name).next().is_none()) {
            Some(volume) => Err(NoScene { volume: volume.name.clone() }),
            None => {
                self.volumes = volumes;
                Ok(())
            }
        }
    }
}
