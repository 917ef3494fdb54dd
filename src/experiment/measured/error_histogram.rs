//! `errors/<cell>.csv`: how many samples of a cell's volume have which error.

use cvr_core::metrics::ErrorHistogram;
use serde::{Deserialize, Serialize};

use crate::experiment::files::folder::OutFolder;
use crate::experiment::files::names::ERRORS;
use crate::experiment::files::whole_file::ResultsError;
use crate::experiment::files::write_results::write_rows;

/// One bin: the errors (decoded − original, data units) from `from` to below `below`. Infinite errors have a row of their
/// own, from `inf` to `inf`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Lowest error.
    pub from: f64,
    /// First error that is too large.
    pub below: f64,
    /// Samples of all frames and channels.
    pub samples: u64,
    /// Share of all samples, `0.0..=1.0`.
    pub share: f64,
}

/// The rows in rising order, from the first bin to the last that is not empty.
#[must_use]
pub fn rows(histogram: &ErrorHistogram) -> Vec<Row> {
    let all = histogram.samples().max(1) as f64;
    let row = |from, below, samples| Row { from, below, samples, share: samples as f64 / all };
    let endless = (histogram.infinite() > 0).then(|| row(f64::INFINITY, f64::INFINITY, histogram.infinite()));
    histogram.bins().map(|bin| row(bin.from, bin.below, bin.samples)).chain(endless).collect()
}

/// Writes the histogram of a cell; returns the path relative to the report's folder.
///
/// # Errors
/// When the file cannot be written.
pub fn write(out: &OutFolder, id: &str, histogram: &ErrorHistogram) -> Result<String, ResultsError> {
    let name = format!("{ERRORS}/{id}.csv");
    write_rows(out, &name, &rows(histogram))?;
    Ok(name)
}
