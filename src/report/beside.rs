//! Every chart as files next to the report: `charts/<name>.svg` to show, `charts/<name>.csv` to redraw.

use super::ReportError;
use super::chart::{Chart, Point};
use super::figure::{ALL_VOLUMES, Figure, Sheet};
use super::page::STYLE;
use crate::experiment::files::folder::OutFolder;
use crate::experiment::files::names::CHARTS;
use crate::experiment::files::whole_file::ResultsError;
use crate::experiment::records::labels::Labels;
use crate::experiment::records::record::{Record, Status};

/// Writes the files, each whole or not at all, and then removes those of charts that no longer exist. `tables` have names
/// without ending, and no drawing.
pub(super) fn write(
    out: &OutFolder,
    figures: &[Figure],
    tables: &[(&str, Sheet)],
    records: &[Record],
    labels: &Labels,
) -> Result<(), ReportError> {
    let folder = out.path().join(CHARTS);
    let written = names(figures, tables.iter().map(|(name, _)| *name));
    out.announce(&written.iter().map(String::as_str).collect::<Vec<_>>())?;
    for figure in figures {
        let title = format!("{}: {}", figure.volume.as_deref().unwrap_or(ALL_VOLUMES), figure.caption);
        let svg = figure.chart.svg_file(&title, STYLE);
        let csv = figure.sheet.as_ref().map_or_else(|| csv(&figure.chart, records, labels), lines);
        let csv = csv.map_err(|e| ResultsError::new(&folder, e))?;
        for (ending, bytes) in [("svg", svg.into_bytes()), ("csv", csv)] {
            out.write(&chart(&figure.name, ending), &bytes)?;
        }
    }
    for (name, sheet) in tables {
        out.write(&chart(name, "csv"), &lines(sheet).map_err(|e| ResultsError::new(&folder, e))?)?;
    }
    Ok(out.keep_only(CHARTS, &written)?)
}

/// The names of all files, relative to the report.
pub(super) fn names<'a>(figures: &[Figure], tables: impl Iterator<Item = &'a str>) -> Vec<String> {
    let of_figures =
        figures.iter().flat_map(|figure| ["svg", "csv"].map(|ending| chart(&figure.name, ending)));
    of_figures.chain(tables.map(|name| chart(name, "csv"))).collect()
}

fn chart(name: &str, ending: &str) -> String {
    format!("{CHARTS}/{name}.{ending}")
}

/// One line per mark, in the order of the records: the cell, the two values under the names of `results.csv`,
/// whether the mark lies on a line of those that none beats, and its series as the legend calls it.
fn csv(chart: &Chart, records: &[Record], labels: &Labels) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let what = ["volume", "codec", "settings", "site", "filter", "renderer", "scene", "device", "status"];
    writer.write_record(what.into_iter().chain([chart.x.field, chart.y.field, "unbeaten", "series"]))?;
    let shown = |p: &&Point| chart.x.shows(p.x) && chart.y.shows(p.y);
    let mut points: Vec<&Point> = chart.points.iter().filter(shown).collect();
    points.sort_by_key(|p| p.cell);
    for point in points {
        let Some(r) = point.cell.and_then(|cell| records.get(cell)) else { continue };
        let status = if r.status == Status::Ok { "ok" } else { "failed" };
        let cell = [&r.volume, &r.codec, &r.settings, &r.site, &r.filter, &r.renderer, &r.scene, &r.device];
        let values = [point.x.to_string(), point.y.to_string(), point.unbeaten.to_string(), labels.series(r)];
        let line = cell.map(String::as_str).into_iter().chain([status]);
        writer.write_record(line.chain(values.iter().map(String::as_str)))?;
    }
    writer.into_inner().map_err(|e| e.into_error().into())
}

/// A sheet as CSV.
fn lines(sheet: &Sheet) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(&sheet.header)?;
    for row in &sheet.rows {
        writer.write_record(row)?;
    }
    writer.into_inner().map_err(|e| e.into_error().into())
}
