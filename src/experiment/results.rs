//! `results.csv` and `results.json`: the records as other programs read them.
//!
//! Columns stand in the order of [`Record`]'s fields. An infinite PSNR is `inf` in CSV and `null` in JSON, which
//! knows no infinity; what was not measured is empty in CSV and `null` in JSON. Both files appear only when they are
//! whole.

use std::path::{Path, PathBuf};

use cvr_core::file;
use serde::{Deserialize, Serialize};

use super::folder::OutFolder;
use super::provenance::{Provenance, RefusedCell};
use super::record::Record;
use super::{checked, series};

const CSV: &str = "results.csv";
const JSON: &str = "results.json";

/// Why a file of results could not be written or read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct ResultsError {
    path: PathBuf,
    problem: String,
}

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
        let bytes = std::fs::read(path).map_err(|e| fail(path, e))?;
        let mut results: Self = serde_json::from_slice(&bytes).map_err(|e| fail(path, e))?;
        results.records.iter_mut().for_each(restore_infinities);
        results.records.iter_mut().for_each(series::restore);
        results.records.iter_mut().for_each(checked::restore);
        Ok(results)
    }
}

impl ResultsError {
    /// A problem with a file or folder.
    #[must_use]
    pub fn new(path: &Path, problem: impl ToString) -> Self {
        fail(path, problem)
    }

    /// The same problem with another file.
    #[must_use]
    pub fn about(self, path: &Path) -> Self {
        Self { path: path.to_owned(), ..self }
    }
}

fn fail(path: &Path, problem: impl ToString) -> ResultsError {
    ResultsError { path: path.to_owned(), problem: problem.to_string() }
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

/// Writes the records as CSV; without records, a header alone.
///
/// # Errors
/// When the file cannot be written.
pub fn write_csv(out: &OutFolder, records: &[Record]) -> Result<(), ResultsError> {
    let text = to_csv(records).map_err(|e| fail(&out.path().join(CSV), e))?;
    out.write(CSV, text.as_bytes())
}

/// Writes rows as CSV, their fields' names above them.
///
/// # Errors
/// When the file cannot be written.
pub fn write_rows<T: Serialize>(out: &OutFolder, name: &str, rows: &[T]) -> Result<(), ResultsError> {
    out.write(name, rows_to_csv(rows).map_err(|e| fail(&out.path().join(name), e))?.as_bytes())
}

/// Writes provenance, records and refused cells as JSON.
///
/// # Errors
/// When the file cannot be written.
pub fn write_json(
    out: &OutFolder,
    provenance: &Provenance,
    records: &[Record],
    refused: &[RefusedCell],
) -> Result<(), ResultsError> {
    let text = to_json(provenance, records, refused).map_err(|e| fail(&out.path().join(JSON), e))?;
    out.write(JSON, &text)
}

/// Provenance, records and refused cells as JSON.
///
/// # Errors
/// When a field has no form in JSON.
pub fn to_json(
    provenance: &Provenance,
    records: &[Record],
    refused: &[RefusedCell],
) -> Result<Vec<u8>, serde_json::Error> {
    #[derive(Serialize)]
    struct Borrowed<'a> {
        provenance: &'a Provenance,
        records: &'a [Record],
        refused: &'a [RefusedCell],
    }
    let results = Borrowed { provenance, records, refused };
    let mut text = serde_json::to_vec_pretty(&results)?;
    text.push(b'\n');
    Ok(text)
}

fn to_csv(records: &[Record]) -> Result<String, csv::Error> {
    if records.is_empty() {
        // The header comes from the first record, so a blank one lends it.
        let text = to_csv(&[Record::default()])?;
        return Ok(text.lines().take(1).flat_map(|line| [line, "\n"]).collect());
    }
    rows_to_csv(records)
}

/// Rows as CSV, their fields' names above them.
///
/// # Errors
/// When a row is no list of plain values.
pub fn rows_to_csv<T: Serialize>(rows: &[T]) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    let bytes = writer.into_inner().map_err(csv::IntoInnerError::into_error)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Writes a file that is whole or not there.
///
/// # Errors
/// When the file cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ResultsError> {
    file::write_whole(path, |file| file.write_all(bytes)).map_err(|e| fail(path, e))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::experiment::record::Status;

    /// A record to start from in tests.
    pub(crate) fn record(volume: &str, codec: &str) -> Record {
        Record { volume: volume.into(), codec: codec.into(), status: Status::Ok, ..Record::default() }
    }

    #[test]
    fn infinity_is_inf_in_csv_and_comes_back_from_json() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.json");
        let lossless = Record {
            psnr_db: Some(f64::INFINITY),
            max_abs_error: Some(0.0),
            image_psnr_db: Some(f64::INFINITY),
            image_ssim: Some(1.0),
            notes: Some("a, b; \"c\"".into()),
            ..record("v", "raw")
        };
        let small =
            Record { image_psnr_whole_db: Some(f64::INFINITY), visible_pixels: Some(9), ..lossless.clone() };
        let records = [lossless.clone(), record("v", "raw"), small];
        let write = |records: &[Record]| {
            std::fs::write(&path, to_json(&Provenance::default(), records, &[]).unwrap()).unwrap();
        };
        write(&records);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains("\"psnr_db\": null"));
        assert_eq!(Results::read(&path).unwrap().records, records);
        let ruined =
            Record { image_psnr_db: Some(f64::NEG_INFINITY), image_ssim: Some(0.2), ..record("v", "x") };
        write(&[ruined]);
        assert_eq!(
            Results::read(&path).unwrap().records[0].image_psnr_db,
            None,
            "no picture gets better by a file"
        );

        let csv = to_csv(&records).unwrap();
        assert!(csv.lines().nth(1).unwrap().contains(",inf,"), "{csv}");
        let read: Vec<Record> =
            csv::Reader::from_reader(csv.as_bytes()).deserialize().collect::<Result<_, _>>().unwrap();
        assert_eq!(read, records);
    }

    #[test]
    fn columns_stand_in_field_order_with_or_without_records() {
        let header = to_csv(&[]).unwrap();
        assert!(
            header
                .starts_with("volume,codec,settings,site,filter,renderer,scene,device,driver,status,error,")
        );
        assert!(
            header.contains(
                ",psnr_blue_db,first_frame,last_frame,frame_figures,error_histogram,mean_abs_error,"
            ) && header.ends_with(
                ",codec_image_ms_ssim,codec_image_flip,series,visible_pixels,payload_bytes,resolution\n"
            ) && header.lines().count() == 1
        );
        assert!(to_csv(&[record("v", "raw")]).unwrap().starts_with(&header));
    }

    #[test]
    fn a_file_that_cannot_be_written_is_named() {
        let error = write_whole(Path::new("no/such/folder/results.csv"), b"").unwrap_err();
        assert!(error.to_string().starts_with("no/such/folder/results.csv: "), "{error}");
    }
}
