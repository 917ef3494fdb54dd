//! Measurements of one cell: one codec, one dial step, all scenes.

use cvr_core::stability::{Observed, Word};
use serde::{Deserialize, Serialize};

use crate::experiment::files::cell_file::Keyed;

/// Whether a codec kept its promises, as files store it.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ended {
    /// It kept its promises.
    #[default]
    Kept,
    /// It declined the volume.
    Refused,
    /// It did not keep its word.
    Broken,
}

/// The figures of one cell. Errors are root mean squares: of voxels in data units, of pictures per visible pixel, full
/// scale 1. `None` = there is nothing to measure, or it is infinite.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Codec id.
    pub codec: String,
    /// Codec and the settings that are not its defaults.
    pub label: String,
    /// All settings.
    pub settings: String,
    /// Subject.
    pub subject: String,
    /// Step of its dial, 1 is the easiest.
    pub step: usize,
    /// Value of the dial.
    pub value: f64,
    /// Number type of the samples.
    pub sample: String,
    /// Voxels along x, y and z.
    pub dims: [u32; 3],
    /// Frames.
    pub frames: u32,
    /// Whether the codec kept its word.
    pub word: Ended,
    /// Why not.
    pub problem: Option<String>,
    /// Notes of the encoder.
    pub notes: Vec<String>,
    /// Bytes of the file.
    pub file_bytes: Option<u64>,
    /// Bytes of the uncompressed volume in a container.
    pub raw_bytes: u64,
    /// The bound that the encoder stated.
    pub error_bound: Option<f64>,
    /// Largest difference of a sample.
    pub max_abs_error: Option<f64>,
    /// Error of the voxels.
    pub voxel_rmse: Option<f64>,
    /// Peak of the PSNR: highest minus lowest value.
    pub span: f64,
    /// Share of the samples that are not what they were, integers rounded first.
    pub changed_samples: Option<f64>,
    /// Errors up to this count as none.
    pub voxel_floor: f64,
    /// Means of the trivial codec along x, y and z.
    pub trivial_grid: Option<[u32; 3]>,
    /// Its error.
    pub trivial_voxel_rmse: Option<f64>,
    /// The pictures, scene by scene. In files a cell's `pictures` are the hashes of those that are kept.
    #[serde(rename = "scenes")]
    pub pictures: Vec<Pictured>,
}

/// The figures of one picture.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pictured {
    /// Scene.
    pub scene: String,
    /// Visible pixels of the reference.
    pub visible_pixels: u64,
    /// Error of the codec's picture.
    pub rmse: Option<f64>,
    /// Its SSIM, per visible pixel.
    pub ssim: Option<f64>,
    /// Error of the trivial codec's picture.
    pub trivial_rmse: Option<f64>,
}

impl Keyed for Measured {
    /// A broken promise is a result like any other, and survives a round trip.
    fn ended_well(&self) -> bool {
        true
    }
}

impl Measured {
    /// Voxels of all frames.
    #[must_use]
    pub fn voxels(&self) -> u64 {
        self.dims.iter().map(|n| u64::from(*n)).product::<u64>() * u64::from(self.frames)
    }

    /// Bits of the whole file per voxel.
    #[must_use]
    pub fn bits_per_voxel(&self) -> Option<f64> {
        self.file_bytes.map(|bytes| bytes as f64 * 8.0 / self.voxels() as f64)
    }

    /// What verdicts are made of.
    #[must_use]
    pub fn observed(&self, exempt: bool) -> Observed {
        let problem = || self.problem.clone().unwrap_or_default();
        Observed {
            word: match self.word {
                Ended::Kept => Word::Kept,
                Ended::Refused => Word::Refused(problem()),
                Ended::Broken => Word::Broken(problem()),
            },
            larger_than_raw: self.file_bytes.is_some_and(|bytes| bytes >= self.raw_bytes),
            voxels: self.voxel_rmse.unwrap_or(f64::INFINITY),
            trivial_voxels: self.trivial_voxel_rmse.unwrap_or(f64::INFINITY),
            voxel_floor: self.voxel_floor,
            exempt,
        }
    }

    /// The figures of a scene.
    #[must_use]
    pub fn picture(&self, scene: &str) -> Option<&Pictured> {
        self.pictures.iter().find(|p| p.scene == scene)
    }
}
