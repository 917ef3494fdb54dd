//! `results.json` as it is read: provenance, records and refused cells.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::whole_file::ResultsError;
use crate::experiment::records::provenance::{Provenance, RefusedCell};
use crate::experiment::records::record::Record;
use crate::experiment::records::{checked, series};

/// All that `results.json` holds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Origin of the records.
    pub provenance: Provenance,
    /// One record per cell that was run.
    pub records: Vec<Record>,
    /// Cells that cannot exist.
    pub refused: Vec<RefusedCell>,
}

impl Results {
    /// Reads a `results.json`. Records of versions that had no series get it, and those of the CPU mirror the
    /// remark that no shader ran. PSNR that is `null` beside a maximum error of 0, or an SSIM of 1, is infinite again.
    ///
    /// # Errors
    /// When the file cannot be read or is none.
    pub fn read(path: &Path) -> Result<Self, ResultsError> {
        let bytes = std::fs::read(path).map_err(|e| ResultsError::new(path, e))?;
        let mut results: Self = serde_json::from_slice(&bytes).map_err(|e| ResultsError::new(path, e))?;
        results.records.iter_mut().for_each(restore_infinities);
        results.records.iter_mut().for_each(series::restore);
        results.records.iter_mut().for_each(checked::restore);
        Ok(results)
    }
}

fn restore_infinities(record: &mut Record) {
    let lossless = record.max_abs_error == Some(0.0);
    // SSIM 1, and not any SSIM: a picture that holds NaN has a PSNR of −∞, which is `null` too.
    let identical = |ssim: Option<f64>| ssim == Some(1.0);
    // Pictures below 11 pixels have no SSIM of the whole frame.
    let small = record.image_ssim_whole.is_none() && record.visible_pixels > Some(0);
    for (psnr, infinite) in [
        (&mut record.psnr_db, lossless),
        (&mut record.image_psnr_db, identical(record.image_ssim)),
        (
            &mut record.image_psnr_whole_db,
            identical(record.image_ssim_whole) || small && identical(record.image_ssim),
        ),
        (&mut record.codec_image_psnr_db, identical(record.codec_image_ssim)),
    ] {
        if psnr.is_none() && infinite {
            *psnr = Some(f64::INFINITY);
        }
    }
}
