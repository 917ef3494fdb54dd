//! The full table: every field of a record except its pictures, which have their own section.

use minijinja::{Value, context};

use cvr_core::metrics;

use super::cells::{distinct, ok};
use super::number::{NONE, bytes, fixed, short};
use crate::experiment::files::names::{ERRORS, FRAMES};
use crate::experiment::records::checked::SHADER_NOT_RUN;
use crate::experiment::records::columns::{self, Format, Shown};
use crate::experiment::records::labels::Labels;
use crate::experiment::records::record::Record;

type Column = columns::Column<Record>;

/// Columns in reading order: what the cell is, then size, voxels, picture, speed, and the rest. The figures that are
/// listed come before speed. Columns that are not named here come last.
#[rustfmt::skip]
const READING: &[&str] = &[
    "volume", "codec", "settings", "site", "filter", "filtering", "renderer", "scene", "status", "bits_per_voxel",
    "file_bytes", "payload_bytes", "resident_bytes", "psnr_db", "foreground_psnr_db", "psnr_red_db", "psnr_green_db",
    "psnr_blue_db", "max_abs_error", "error_bound", "visible_pixels", "image_psnr_db", "image_ssim",
    "codec_image_psnr_db", "codec_image_ssim", "image_psnr_whole_db", "image_ssim_whole", "relative_frame_time",
    "relative_frame_time_iqr", "frame_ms", "frame_ms_iqr", "frame_cpu_ms", "frame_clock", "frame_pairs",
    "encode_seconds", "decode_seconds", "decode_voxels_per_second", "device_decode_ms", "device_decode_bytes",
    "stages", "skipping", "skipping_gain", "skipping_gain_iqr", "empty_macrocells", "skipping_mismatches",
    "macrocell_seconds", "voxels", "frames", "first_frame", "last_frame", "frame_figures", "error_histogram",
    "parity_mismatches", "replaced_samples", "series", "device", "driver", "error", "notes",
];

/// The first column of speed.
const SPEED: &str = "relative_frame_time";

/// A record's value in a column.
fn text(column: &Column, record: &Record, labels: &Labels) -> String {
    match (column.shown.format, (column.value)(record)) {
        (Format::Settings, _) => some(Some(labels.settings(record).as_str()).filter(|text| !text.is_empty())),
        (Format::Series, _) => labels.series(record),
        (Format::Parity, _) if record.shader_not_run() => SHADER_NOT_RUN.to_owned(),
        (Format::Stages, columns::Value::Count(None)) => "all".to_owned(),
        (Format::Bytes, columns::Value::Count(count)) => bytes(count),
        (Format::Millions, columns::Value::Number(number)) => short(number.map(|number| number / 1e6)),
        (Format::Fixed(decimals), columns::Value::Number(number)) => fixed(number, decimals),
        (_, columns::Value::Number(number)) => short(number),
        (_, columns::Value::Count(count)) => count.map_or_else(|| NONE.to_owned(), |n| n.to_string()),
        (_, columns::Value::Switch(on)) => if on { "yes" } else { "no" }.to_owned(),
        (_, columns::Value::Text(text)) => some(text),
    }
}

/// All of what the text says in part.
fn whole(column: &Column, record: &Record) -> Option<String> {
    let (Format::Settings | Format::Series, columns::Value::Text(Some(whole))) =
        (column.shown.format, (column.value)(record))
    else {
        return None;
    };
    (!whole.is_empty()).then(|| whole.to_owned())
}

/// The file that the text names. Only what lies below the report is linked: a record is data.
fn link(column: &Column, record: &Record) -> Option<String> {
    let (Format::File, columns::Value::Text(Some(path))) = (column.shown.format, (column.value)(record))
    else {
        return None;
    };
    let is_below = [FRAMES, ERRORS].iter().any(|folder| path.starts_with(&format!("{folder}/")));
    is_below.then(|| path.to_owned())
}

fn some(text: Option<&str>) -> String {
    text.unwrap_or(NONE).to_owned()
}

/// All columns of the table, in reading order.
fn columns() -> Vec<Column> {
    let place = |name: &str| READING.iter().position(|other| *other == name).unwrap_or(READING.len());
    let named = |column: &Column| match metrics::figures().find(|figure| figure.name == column.name) {
        Some(figure) => {
            let shown = Shown { heading: figure.heading, axis: Some(figure.axis), ..column.shown };
            Column { shown, ..*column }
        }
        None => *column,
    };
    let shown = Record::COLUMNS.iter().filter(|column| column.shown.format != Format::Picture);
    let mut all: Vec<Column> = shown.map(named).collect();
    all.sort_by_key(|column| match column.shown.format {
        Format::Listed => (place(SPEED), 0),
        _ => (place(column.name), 1),
    });
    all
}

/// Columns that can be an axis of a chart, as (field, name and unit): every column of numbers.
pub(super) fn quantities() -> impl Iterator<Item = (&'static str, &'static str)> {
    let numeric = columns().into_iter().filter(|c| c.shown.format.is_numeric());
    numeric.map(|c| (c.name, c.shown.axis.unwrap_or(c.shown.heading)))
}

/// The table as the template reads it.
pub(super) fn table(records: &[Record], labels: &Labels) -> Value {
    let class = |c: &Column| match (c.shown.format.is_numeric(), c.shown.secondary) {
        (true, true) => "n secondary",
        (true, false) => "n",
        (false, true) => "secondary",
        (false, false) => "",
    };
    let all = columns();
    let columns: Vec<Value> = all
        .iter()
        .map(|c| context! { field => c.name, heading => c.shown.heading, class => class(c) })
        .collect();
    let row = |record: &Record| {
        let cell = |c: &Column| {
            let text = text(c, record, labels);
            context! { text => text, whole => whole(c, record), class => class(c), link => link(c, record) }
        };
        let cells: Vec<Value> = all.iter().map(cell).collect();
        context! { failed => !ok(record), cells => cells }
    };
    let rows: Vec<Value> = records.iter().map(row).collect();
    let codecs = distinct(records.iter().map(|r| r.codec.clone())).into_iter();
    let shared = codecs.map(|codec| (labels.shared(&codec), codec)).filter(|(shared, _)| !shared.is_empty());
    let shared: Vec<Value> =
        shared.map(|(settings, codec)| context! { codec => codec, settings => settings }).collect();
    context! { columns => columns, rows => rows, shared => shared }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    use crate::experiment::records::record::tests::record;

    #[test]
    fn no_field_of_a_record_is_forgotten() {
        let json = serde_json::to_value(record("v", "raw")).unwrap();
        let shown: Vec<&str> = columns().iter().map(|c| c.name).collect();
        for field in json.as_object().unwrap().keys() {
            let picture = ["image", "error_image"].contains(&field.as_str());
            assert_eq!(shown.iter().filter(|s| *s == field).count(), usize::from(!picture), "{field}");
        }
    }

    #[test]
    fn reading_order_names_columns_once() {
        let names: BTreeSet<&str> = READING.iter().copied().collect();
        assert_eq!(names.len(), READING.len());
        for name in READING {
            assert!(Record::COLUMNS.iter().any(|column| column.name == *name), "{name} is no column");
        }
        assert!(READING.contains(&SPEED));
    }

    #[test]
    fn quantities_have_names_of_their_own() {
        let names: BTreeSet<&str> = quantities().map(|(_, name)| name).collect();
        assert_eq!(names.len(), quantities().count());
        assert!(names.contains("PSNR of the voxels, dB") && !names.contains("settings"));
    }

    #[test]
    fn figures_are_called_what_the_list_calls_them() {
        let all = columns();
        for figure in metrics::figures() {
            let column = all.iter().find(|c| c.name == figure.name).unwrap();
            assert_eq!((column.shown.heading, column.shown.axis), (figure.heading, Some(figure.axis)));
        }
    }

    #[test]
    fn settings_that_differ_are_shown_and_all_are_told() {
        let with = |settings: &str| Record { settings: settings.into(), ..record("v", "vq") };
        let cells = [with("block=2 seed=1"), with("block=4 seed=1")];
        let labels = Labels::of(&cells);
        let column = columns().into_iter().find(|c| c.name == "settings").unwrap();
        assert_eq!(text(&column, &cells[1], &labels), "block=4");
        assert_eq!(whole(&column, &cells[1]).as_deref(), Some("block=4 seed=1"));
        assert_eq!(text(&column, &cells[1], &Labels::of(&cells[1..])), NONE);
        assert_eq!(whole(&column, &record("v", "raw")), None);
        let shared = table(&cells, &labels).get_attr("shared").unwrap().get_item_by_index(0).unwrap();
        assert_eq!(shared.get_attr("settings").unwrap().as_str(), Some("seed=1"));
    }

    #[test]
    fn files_below_the_report_are_linked_and_no_others() {
        let column = columns().into_iter().find(|c| c.name == "error_histogram").unwrap();
        let linked = |path: &str| {
            link(&column, &Record { error_histogram: Some(path.to_owned()), ..record("v", "raw") })
        };
        assert_eq!(linked("errors/a.csv").as_deref(), Some("errors/a.csv"));
        assert_eq!(linked("javascript:alert(1)"), None);
        assert_eq!(link(&column, &record("v", "raw")), None);
    }
}
