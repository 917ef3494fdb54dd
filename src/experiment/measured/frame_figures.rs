//! `frames/<cell>.csv`: what a cell measured of every frame of its volume.

use cvr_core::metrics::FrameError;
use serde::{Deserialize, Serialize};

use crate::experiment::files::folder::OutFolder;
use crate::experiment::files::names::FRAMES;
use crate::experiment::files::whole_file::ResultsError;
use crate::experiment::files::write_results::write_rows;
use crate::experiment::records::record::Record;

/// One frame. The columns that begin with `psnr_db` concern all its voxels. The columns from `image_psnr_db` on are
/// empty if the scene does not draw the frame. Names and meanings are those of [`Record`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameFigures {
    /// Number of the frame, counted from 0.
    pub frame: u32,
    /// PSNR of the frame, with the peak of the whole volume.
    pub psnr_db: f64,
    /// Largest difference of a voxel of the frame.
    pub max_abs_error: f64,
    /// PSNR of the picture against the reference, per visible pixel.
    pub image_psnr_db: Option<f64>,
    /// SSIM against the reference, per visible pixel.
    pub image_ssim: Option<f64>,
    /// PSNR of the whole frame.
    pub image_psnr_whole_db: Option<f64>,
    /// SSIM of the whole frame.
    pub image_ssim_whole: Option<f64>,
    /// PSNR against raw under the same site and filter.
    pub codec_image_psnr_db: Option<f64>,
    /// SSIM against raw under the same site and filter.
    pub codec_image_ssim: Option<f64>,
    /// Median frame time.
    pub frame_ms: Option<f64>,
    /// Median of the paired ratio to the baseline's frame time.
    pub relative_frame_time: Option<f64>,
    /// Interquartile range of that ratio.
    pub relative_frame_time_iqr: Option<f64>,
    /// Median time in which the device decodes the frame.
    pub device_decode_ms: Option<f64>,
    /// Samples on which shader and CPU decoder disagree.
    pub parity_mismatches: Option<u64>,
    /// Visible pixels of the reference. If 0, no figure of the picture is defined.
    #[serde(default)]
    pub visible_pixels: Option<u64>,
}

/// The figures of all frames of a volume. `drawn` are the records of the frames that the scene draws.
#[must_use]
pub fn figures(errors: &[FrameError], drawn: &[Record]) -> Vec<FrameFigures> {
    let of_frame = |(frame, error): (u32, &FrameError)| {
        let drawn = drawn.iter().find(|r| r.first_frame == frame).cloned().unwrap_or_default();
        FrameFigures {
            frame,
            psnr_db: error.psnr_db,
            max_abs_error: error.max_abs_error,
            image_psnr_db: drawn.image_psnr_db,
            image_ssim: drawn.image_ssim,
            image_psnr_whole_db: drawn.image_psnr_whole_db,
            image_ssim_whole: drawn.image_ssim_whole,
            codec_image_psnr_db: drawn.codec_image_psnr_db,
            codec_image_ssim: drawn.codec_image_ssim,
            frame_ms: drawn.frame_ms,
            relative_frame_time: drawn.relative_frame_time,
            relative_frame_time_iqr: drawn.relative_frame_time_iqr,
            device_decode_ms: drawn.device_decode_ms,
            parity_mismatches: drawn.parity_mismatches,
            visible_pixels: drawn.visible_pixels,
        }
    };
    (0..).zip(errors).map(of_frame).collect()
}

/// Writes the figures of a cell into a folder that only sequences have. Returns the path relative to the report's
/// folder.
///
/// # Errors
/// When the file cannot be written.
pub fn write(out: &OutFolder, id: &str, figures: &[FrameFigures]) -> Result<String, ResultsError> {
    let name = format!("{FRAMES}/{id}.csv");
    write_rows(out, &name, figures)?;
    Ok(name)
}
