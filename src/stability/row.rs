//! One verdict on what was measured, as a row of a table.

use cvr_core::stability::{Reason, Verdict};
use serde::Serialize;

/// Name of the column of the voxels, next to those of the scenes.
pub const VOXELS: &str = "voxels";

/// One verdict: a codec at a step, of its voxels or in a scene. PSNR is empty where nothing is lost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Codec id.
    pub codec: String,
    /// Codec and the settings that are not its defaults.
    pub label: String,
    /// All settings.
    pub settings: String,
    /// Subject.
    pub subject: String,
    /// What its dial turns.
    pub dial: String,
    /// Step of the dial, 1 is the easiest.
    pub step: usize,
    /// Value of the dial.
    pub value: f64,
    /// `voxels`, or the scene.
    pub scene: String,
    /// The verdict.
    pub verdict: Verdict,
    /// Why.
    pub reason: Option<Reason>,
    /// Number type of the samples.
    pub sample: String,
    /// Voxels of all frames.
    pub voxels: u64,
    /// Bytes of the file.
    pub file_bytes: Option<u64>,
    /// Bits of the file per voxel.
    pub bits_per_voxel: Option<f64>,
    /// PSNR of the voxels in dB.
    pub psnr_db: Option<f64>,
    /// Largest difference of a sample.
    pub max_abs_error: Option<f64>,
    /// The codec's promise for it.
    pub error_bound: Option<f64>,
    /// Share of samples that are not what they were.
    pub changed_samples: Option<f64>,
    /// PSNR of the trivial codec's voxels in dB.
    pub trivial_psnr_db: Option<f64>,
    /// Picture error, root mean square per visible pixel.
    pub image_rmse: Option<f64>,
    /// The same in dB.
    pub image_psnr_db: Option<f64>,
    /// SSIM of the picture.
    pub image_ssim: Option<f64>,
    /// Picture error of the trivial codec.
    pub trivial_image_rmse: Option<f64>,
    /// Picture error of the codec at the dial's easiest step.
    pub easiest_image_rmse: Option<f64>,
    /// Visible pixels of the reference; without any there is little to see.
    pub visible_pixels: Option<u64>,
    /// What broke the codec's word, or why it refuses.
    pub problem: Option<String>,
    /// Notes of the encoder.
    pub notes: Option<String>,
}
