//! Data of the page's script: records as JSON. No text in them can leave the JSON.

use serde::Serialize;

use super::cells::{Baseline, blends, ok};
use super::chart::{Mark, Shape};
use super::charts::{Palette, baseline_mark, failure_entry, filter_entries};
use super::reproduce;
use super::table::quantities;
use crate::experiment::records::labels::full_cell;
use crate::experiment::records::provenance::Provenance;
use crate::experiment::records::record::Record;

/// A value of a quantity: JSON knows neither infinity nor NaN.
#[derive(Serialize)]
#[serde(untagged)]
enum Number {
    Finite(f64),
    Word(&'static str),
}

#[derive(Serialize)]
struct Quantity {
    field: &'static str,
    name: &'static str,
}

/// A mark around the origin, as the drawn charts have it.
#[derive(PartialEq, Serialize)]
struct Drawn {
    d: String,
    fill: String,
    stroke: String,
    width: f64,
    letter: Option<char>,
    label: String,
}

#[derive(Serialize)]
struct Cell<'a> {
    name: String,
    /// The name with all settings.
    full: String,
    volume: &'a str,
    scene: &'a str,
    renderer: &'a str,
    device: &'a str,
    /// Why it failed.
    failed: Option<&'a str>,
    command: Option<String>,
    /// Index of its mark.
    mark: usize,
    filled: bool,
    values: Vec<Option<Number>>,
}

#[derive(Serialize)]
struct Data<'a> {
    quantities: Vec<Quantity>,
    marks: Vec<Drawn>,
    /// What filled and hollow mean.
    filters: Vec<Drawn>,
    cells: Vec<Cell<'a>>,
}

/// JSON for a `<script type="application/json">`.
pub(super) fn json(provenance: &Provenance, records: &[Record], palette: &Palette) -> String {
    let mut marks: Vec<Drawn> = Vec::new();
    let mut cells = Vec::new();
    for record in records {
        let (mark, label) = mark(record, palette);
        let drawn = draw(&mark, label);
        let at = marks.iter().position(|m| *m == drawn).unwrap_or_else(|| {
            marks.push(drawn);
            marks.len() - 1
        });
        cells.push(Cell {
            name: palette.labels.cell(record),
            full: full_cell(record),
            volume: &record.volume,
            scene: &record.scene,
            renderer: &record.renderer,
            device: &record.device,
            failed: (!ok(record)).then(|| record.error.as_deref().unwrap_or("no reason given")),
            command: reproduce::command(record, provenance),
            mark: at,
            filled: blends(record),
            values: values(record),
        });
    }
    let all: Vec<&Record> = records.iter().collect();
    let filters = filter_entries(&all, Shape::Circle);
    let data = Data {
        quantities: quantities().map(|(field, name)| Quantity { field, name }).collect(),
        marks,
        filters: filters.into_iter().map(|entry| draw(&entry.mark, entry.label)).collect(),
        cells,
    };
    // Strings and finite numbers always serialise.
    in_script(&serde_json::to_string(&data).unwrap_or_default())
}

/// Within strings alone can these characters stand; written as escapes they end no element and open no comment.
fn in_script(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        match c {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => out.push_str(&format!("\\u{:04x}", u32::from(c))),
            _ => out.push(c),
        }
    }
    out
}

/// As in the chart of frame times, and what the legend calls it.
fn mark(record: &Record, palette: &Palette) -> (Mark, String) {
    if !ok(record) {
        let entry = failure_entry();
        return (entry.mark, entry.label);
    }
    if let Some(baseline) = Baseline::of(record) {
        return (baseline_mark(baseline), baseline.label().to_owned());
    }
    let mark = Mark { filled: blends(record), ..palette.site_mark(record) };
    (mark, format!("{}, {}", palette.labels.series(record), record.site))
}

fn draw(mark: &Mark, label: String) -> Drawn {
    let (fill, stroke) = mark.paint();
    let letter = if let Shape::Letter(letter) = mark.shape { Some(letter) } else { None };
    Drawn { d: mark.path_at_origin(), fill, stroke, width: mark.stroke_width(), letter, label }
}

/// Values in the order of [`quantities`], as the record itself writes them to CSV, which knows infinity.
fn values(record: &Record) -> Vec<Option<Number>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let written = writer.serialize(record).ok().and_then(|()| writer.into_inner().ok()).unwrap_or_default();
    let mut reader = csv::Reader::from_reader(written.as_slice());
    let names = reader.headers().cloned().unwrap_or_default();
    let row = reader.records().next().and_then(Result::ok).unwrap_or_default();
    let value = |field: &str| {
        let at = names.iter().position(|name| name == field)?;
        match row.get(at)?.parse::<f64>().ok()? {
            v if v.is_finite() => Some(Number::Finite(v)),
            f64::INFINITY => Some(Number::Word("inf")),
            _ => None,
        }
    };
    quantities().map(|(field, _)| value(field)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::records::record::tests::record;

    #[test]
    fn hostile_names_stay_within_their_strings() {
        let evil = "</script><script>alert(1)//\u{2028}<!--&";
        let records = [Record { psnr_db: Some(f64::INFINITY), ..record(evil, "s3dc") }];
        let json = json(&Provenance::default(), &records, &Palette::new(&records));
        assert!(!json.contains(['<', '>', '&', '\u{2028}']), "{json}");
        let read: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(read["cells"][0]["volume"], evil);
        let quantities = read["quantities"].as_array().unwrap();
        let at = quantities.iter().position(|q| q["field"] == "psnr_db").unwrap();
        assert_eq!(read["cells"][0]["values"][at], "inf");
    }

    #[test]
    fn every_number_of_a_record_can_be_an_axis() {
        let timed =
            Record { voxels: 4096, frame_pairs: Some(9), frame_ms: Some(0.125), ..record("v", "raw") };
        let fields: Vec<&str> = quantities().map(|(field, _)| field).collect();
        let values = values(&timed);
        for (field, expected) in [("voxels", 4096.0), ("frame_pairs", 9.0), ("frame_ms", 0.125)] {
            let at = fields.iter().position(|f| *f == field).unwrap();
            assert!(matches!(values[at], Some(Number::Finite(v)) if v == expected), "{field}");
        }
        assert!(values[fields.iter().position(|f| *f == "psnr_db").unwrap()].is_none());
    }
}
