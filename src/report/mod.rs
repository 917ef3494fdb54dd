//! The report: one HTML file that holds everything, reads without JavaScript and without a network, and prints. With
//! JavaScript its reader chooses axes, reads the command behind a point, and lays two pictures over each other.
//! `charts/` beside it holds every chart as SVG and CSV.
//!
//! PNG pictures are embedded up to [`EMBEDDED_BYTES`]. Beyond that the page links to them and says so: no browser would open
//! the page of a large sweep otherwise.

pub mod chart;

mod bd_table;
mod beside;
mod bjontegaard;
mod cells;
mod charts;
mod claim;
mod curves;
mod data;
mod embed;
mod figure;
mod noise;
mod number;
mod page;
mod pareto;
mod pictures;
mod reproduce;
mod script;
mod summary;
mod table;

pub(crate) use page::STYLE;
#[cfg(test)]
mod tests;

pub use claim::claim;
pub use embed::EMBEDDED_BYTES;

use std::path::PathBuf;

use crate::experiment::files::folder::OutFolder;
use crate::experiment::files::whole_file::ResultsError;
use crate::experiment::records::provenance::{Provenance, RefusedCell};
use crate::experiment::records::record::Record;

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The page could not be put together.
    #[error("the report's template failed: {0}")]
    Template(#[from] minijinja::Error),
    /// The file could not be written.
    #[error(transparent)]
    File(#[from] ResultsError),
}

/// Name in `charts/`, without ending, of the differences between curves. It lacks the kind that ends the names of charts.
const BJONTEGAARD: &str = "bjontegaard";

/// Name of the page.
const PAGE: &str = "report.html";

/// Writes `report.html` and `charts/` into a folder and returns its path; the file appears only when it is whole. Pictures are
/// taken from the records' paths relative to the folder.
///
/// # Errors
/// When the page cannot be put together or written. A picture that cannot be read is not an error: the page says so.
pub fn write(
    out: &OutFolder,
    provenance: &Provenance,
    records: &[Record],
    refused: &[RefusedCell],
) -> Result<PathBuf, ReportError> {
    let dir = out.path();
    let palette = charts::Palette::new(records);
    let figures = charts::figures(dir, records, provenance, &palette);
    let html = page::render(dir, provenance, records, refused, (&figures, &palette))?;
    // Charts first: a report links to no file that is not there.
    let tables: Vec<_> =
        bd_table::sheet(records, &palette.labels).map(|sheet| (BJONTEGAARD, sheet)).into_iter().collect();
    beside::write(out, &figures, &tables, records, &palette.labels)?;
    out.write(PAGE, html.as_bytes())?;
    Ok(dir.join(PAGE))
}
