//! Writing `results.csv` and `results.json`: the records as other programs read them.
//!
//! Columns stand in the order of [`Record`]'s fields. An infinite PSNR is `inf` in CSV and `null` in JSON, which
//! knows no infinity; what was not measured is empty in CSV and `null` in JSON. Both files appear only when they are
//! whole.

use serde::Serialize;

use super::folder::OutFolder;
use super::whole_file::ResultsError;
use crate::experiment::records::provenance::{Provenance, RefusedCell};
use crate::experiment::records::record::Record;

const CSV: &str = "results.csv";
const JSON: &str = "results.json";

/// Writes the records as CSV; without records, a header alone.
///
/// # Errors
/// When the file cannot be written.
pub fn write_csv(out: &OutFolder, records: &[Record]) -> Result<(), ResultsError> {
    let text = to_csv(records).map_err(|e| ResultsError::new(&out.path().join(CSV), e))?;
    out.write(CSV, text.as_bytes())
}

/// Writes rows as CSV, their fields' names above them.
///
/// # Errors
/// When the file cannot be written.
pub fn write_rows<T: Serialize>(out: &OutFolder, name: &str, rows: &[T]) -> Result<(), ResultsError> {
    out.write(name, rows_to_csv(rows).map_err(|e| ResultsError::new(&out.path().join(name), e))?.as_bytes())
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
    let text =
        to_json(provenance, records, refused).map_err(|e| ResultsError::new(&out.path().join(JSON), e))?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::files::results::Results;
    use crate::experiment::records::record::tests::record;

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
}
