//! Provenance: everything needed to repeat results or to question them.

use serde::{Deserialize, Serialize};

/// The origin of a set of records.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the experiment.
    #[serde(default)]
    pub experiment: String,
    /// Version of this software.
    pub version: String,
    /// Commit that it was built from; `None` when unknown.
    pub git_hash: Option<String>,
    /// Graphics adapter, or `cpu`.
    pub adapter: String,
    /// Driver and its version.
    pub driver: String,
    /// Graphics interface: `Vulkan`, `Metal`, …
    pub backend: String,
    /// Processor.
    pub cpu: String,
    /// Processor cores that were used.
    pub cores: u32,
    /// The inputs.
    pub volumes: Vec<VolumeProvenance>,
    /// Seed of everything random.
    pub seed: u64,
    /// Text of the experiment's configuration.
    pub config: String,
    /// Overridden keys of the configuration, as `--set` had them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub overrides: Vec<String>,
    /// The command that ran it.
    pub command_line: String,
    /// When it was run: RFC 3339, UTC.
    pub date: String,
    /// What relative frame times refer to.
    pub baseline: String,
    /// The pictures that `image_*` metrics compare with.
    #[serde(default)]
    pub references: Vec<ReferencePicture>,
    /// The merged runs. Empty for a single run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<Part>,
}

/// One of several runs that were merged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Name of its folder, without the folders above it.
    pub folder: String,
    /// Records that it had.
    pub records: u64,
    /// Version of this software.
    pub version: String,
    /// Commit that it was built from; `None` when unknown.
    pub git_hash: Option<String>,
    /// Graphics adapter, or `cpu`.
    pub adapter: String,
    /// Driver and its version.
    pub driver: String,
    /// Graphics interface.
    pub backend: String,
    /// Processor.
    pub cpu: String,
    /// Processor cores that were used.
    pub cores: u32,
    /// The command that ran it.
    pub command_line: String,
    /// When it was run: RFC 3339, UTC.
    pub date: String,
}

/// One input volume.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct VolumeProvenance {
    /// Name used in records.
    pub name: String,
    /// File or generator.
    pub source: String,
    /// BLAKE3 of the input's bytes, in hexadecimal.
    pub blake3: String,
    /// Voxels along x, y, z.
    pub dims: [u32; 3],
    /// Number type.
    pub dtype: String,
    /// Distance between voxel centres along x, y, z.
    pub spacing: [f64; 3],
    /// Lowest and highest value.
    pub range: [f64; 2],
}

/// The reference picture of one volume, scene and renderer: uncompressed, manual trilinear filter, same step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReferencePicture {
    /// Volume name.
    pub volume: String,
    /// Scene name.
    pub scene: String,
    /// Renderer.
    pub renderer: String,
    /// The picture, relative to the report.
    pub image: String,
    /// Pictures of later frames that the scene draws.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub later_frames: Vec<String>,
}

impl ReferencePicture {
    /// The pictures of all frames.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        std::iter::once(&self.image).chain(&self.later_frames).map(String::as_str)
    }
}

/// A cell that was asked for and cannot exist.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RefusedCell {
    /// Volume name.
    pub volume: String,
    /// Codec id.
    pub codec: String,
    /// Settings, `name=value` separated by spaces.
    pub settings: String,
    /// Decode site.
    pub site: String,
    /// Filter.
    pub filter: String,
    /// Renderer.
    pub renderer: String,
    /// Scene name.
    pub scene: String,
    /// Whether empty macrocells were to be skipped.
    #[serde(default)]
    pub skipping: bool,
    /// Number of stages to decode. `None` for all.
    #[serde(default)]
    pub stages: Option<u8>,
    /// Resolution that was to be decoded; 0 is the full one.
    #[serde(default)]
    pub resolution: u8,
    /// Why.
    pub reason: String,
}
