//! The full table: every field of a record but its pictures, which stand in their own section.

use minijinja::{Value, context};

use cvr_core::metrics;

use super::cells::{distinct, ok};
use super::number::{NONE, bytes, fixed, short};
use crate::experiment::checked::SHADER_NOT_RUN;
use crate::experiment::files::{ERRORS, FRAMES};
use crate::experiment::labels::Labels;
use crate::experiment::record::{Record, is_listed};

/// One column.
#[derive(Copy, Clone)]
struct Column {
    /// The record's field, as in `results.csv`.
    field: &'static str,
    /// Heading.
    heading: &'static str,
    /// Numbers stand to the right.
    numeric: bool,
    /// Left out on paper, where there is no room for all.
    secondary: bool,
    /// Name and unit on the axis of a chart, where the heading alone would not tell.
    axis: Option<&'static str>,
    text: Text,
}

/// What a column says of a record.
#[derive(Copy, Clone)]
enum Text {
    Of(fn(&Record) -> String),
    /// A figure that is listed, by the column's field.
    Figure,
    /// The settings that differ among the cells of a codec.
    Settings,
    /// What the record's curve is called.
    Series,
    /// A file beside the report, linked.
    File(fn(&Record) -> &Option<String>),
}

impl Column {
    fn text(&self, record: &Record, labels: &Labels) -> String {
        match self.text {
            Text::Settings => some(&Some(labels.settings(record)).filter(|text| !text.is_empty())),
            Text::Series => labels.series(record),
            Text::Of(text) => text(record),
            Text::Figure => short(record.figure(self.field)),
            Text::File(path) => some(path(record)),
        }
    }

    /// All of what the text tells in part.
    fn whole(&self, record: &Record) -> Option<String> {
        let whole = match self.text {
            Text::Settings => &record.settings,
            Text::Series => &record.series,
            _ => return None,
        };
        (!whole.is_empty()).then(|| whole.clone())
    }

    /// The file that the text names. Only what lies below the report is linked: a record is data.
    fn link(&self, record: &Record) -> Option<String> {
        let Text::File(path) = self.text else { return None };
        let below =
            |path: &&String| [FRAMES, ERRORS].iter().any(|folder| path.starts_with(&format!("{folder}/")));
        path(record).as_ref().filter(below).cloned()
    }
}

const fn text(field: &'static str, heading: &'static str, text: fn(&Record) -> String) -> Column {
    Column { field, heading, numeric: false, secondary: false, axis: None, text: Text::Of(text) }
}

const fn number(field: &'static str, heading: &'static str, text: fn(&Record) -> String) -> Column {
    Column { field, heading, numeric: true, secondary: false, axis: None, text: Text::Of(text) }
}

const fn file(field: &'static str, heading: &'static str, path: fn(&Record) -> &Option<String>) -> Column {
    Column { field, heading, numeric: false, secondary: false, axis: None, text: Text::File(path) }
}

const fn secondary(column: Column) -> Column {
    Column { secondary: true, ..column }
}

/// Names a column on the axis of a chart; values there are the record's own, in the record's unit.
const fn axis(name: &'static str, column: Column) -> Column {
    Column { axis: Some(name), ..column }
}

fn some(text: &Option<String>) -> String {
    text.clone().unwrap_or_else(|| NONE.to_owned())
}

fn count(n: Option<u64>) -> String {
    n.map_or_else(|| NONE.to_owned(), |n| n.to_string())
}

/// Columns in reading order: what the cell is, then size, voxels, picture, speed, and the rest. The figures that are
/// listed come before speed.
const COLUMNS: &[Column] = &[
    text("volume", "volume", |r| r.volume.clone()),
    text("codec", "codec", |r| r.codec.clone()),
    Column { text: Text::Settings, ..text("settings", "settings", |_| String::new()) },
    text("site", "site", |r| r.site.clone()),
    text("filter", "filter", |r| r.filter.clone()),
    secondary(text("filtering", "filtered by", |r| some(&r.filtering))),
    secondary(text("renderer", "renderer", |r| r.renderer.clone())),
    text("scene", "scene", |r| r.scene.clone()),
    text("status", "status", |r| if ok(r) { "ok" } else { "failed" }.to_owned()),
    axis(
        "bits per voxel, whole file",
        number("bits_per_voxel", "bits per voxel", |r| short(r.bits_per_voxel)),
    ),
    axis("size of the file, bytes", number("file_bytes", "file", |r| bytes(r.file_bytes))),
    secondary(axis(
        "size without the header, bytes",
        number("payload_bytes", "without header", |r| bytes(r.payload_bytes)),
    )),
    secondary(axis(
        "in device memory, bytes",
        number("resident_bytes", "in device memory", |r| bytes(r.resident_bytes)),
    )),
    axis("PSNR of the voxels, dB", number("psnr_db", "PSNR, dB", |r| fixed(r.psnr_db, 2))),
    secondary(axis(
        "PSNR of the foreground voxels, dB",
        number("foreground_psnr_db", "foreground PSNR, dB", |r| fixed(r.foreground_psnr_db, 2)),
    )),
    secondary(axis("PSNR of red, dB", number("psnr_red_db", "PSNR of red, dB", |r| fixed(r.psnr_red_db, 2)))),
    secondary(axis(
        "PSNR of green, dB",
        number("psnr_green_db", "PSNR of green, dB", |r| fixed(r.psnr_green_db, 2)),
    )),
    secondary(axis(
        "PSNR of blue, dB",
        number("psnr_blue_db", "PSNR of blue, dB", |r| fixed(r.psnr_blue_db, 2)),
    )),
    axis(
        "largest error of a voxel, data units",
        number("max_abs_error", "max error", |r| short(r.max_abs_error)),
    ),
    axis("bound of the error, data units", number("error_bound", "bound", |r| short(r.error_bound))),
    secondary(number("visible_pixels", "visible pixels", |r| count(r.visible_pixels))),
    axis(
        "PSNR of the picture, dB",
        number("image_psnr_db", "picture PSNR, dB", |r| fixed(r.image_psnr_db, 2)),
    ),
    axis("SSIM of the picture", number("image_ssim", "picture SSIM", |r| fixed(r.image_ssim, 4))),
    secondary(axis(
        "PSNR of the picture against raw, dB",
        number("codec_image_psnr_db", "codec's picture PSNR, dB", |r| fixed(r.codec_image_psnr_db, 2)),
    )),
    secondary(axis(
        "SSIM of the picture against raw",
        number("codec_image_ssim", "codec's picture SSIM", |r| fixed(r.codec_image_ssim, 4)),
    )),
    secondary(axis(
        "PSNR of the whole frame, dB",
        number("image_psnr_whole_db", "whole-frame PSNR, dB", |r| fixed(r.image_psnr_whole_db, 2)),
    )),
    secondary(axis(
        "SSIM of the whole frame",
        number("image_ssim_whole", "whole-frame SSIM", |r| fixed(r.image_ssim_whole, 4)),
    )),
    axis(
        "frame time ÷ baseline A",
        number("relative_frame_time", "relative frame time", |r| short(r.relative_frame_time)),
    ),
    secondary(axis(
        "IQR of frame time ÷ baseline A",
        number("relative_frame_time_iqr", "its IQR", |r| short(r.relative_frame_time_iqr)),
    )),
    axis("frame time, ms", number("frame_ms", "frame, ms", |r| short(r.frame_ms))),
    secondary(axis(
        "IQR of the frame time, ms",
        number("frame_ms_iqr", "its IQR, ms", |r| short(r.frame_ms_iqr)),
    )),
    secondary(axis(
        "CPU time per frame, ms",
        number("frame_cpu_ms", "CPU per frame, ms", |r| short(r.frame_cpu_ms)),
    )),
    secondary(text("frame_clock", "clock", |r| some(&r.frame_clock))),
    secondary(axis("pairs timed", number("frame_pairs", "pairs", |r| count(r.frame_pairs.map(u64::from))))),
    secondary(axis("encoding, s", number("encode_seconds", "encode, s", |r| short(r.encode_seconds)))),
    secondary(axis(
        "decoding on the CPU, s",
        number("decode_seconds", "decode, s", |r| short(r.decode_seconds)),
    )),
    secondary(axis(
        "decoding on the CPU, voxels/s",
        number("decode_voxels_per_second", "Mvoxel/s", |r| {
            short(r.decode_voxels_per_second.map(|v| v / 1e6))
        }),
    )),
    secondary(axis(
        "decoding on the device, ms",
        number("device_decode_ms", "decode on the device, ms", |r| short(r.device_decode_ms)),
    )),
    secondary(axis(
        "on the device while decoding, bytes",
        number("device_decode_bytes", "on the device meanwhile", |r| bytes(r.device_decode_bytes)),
    )),
    text("stages", "stages", |r| r.stages.map_or("all".to_owned(), |stages| stages.to_string())),
    text("skipping", "skipping", |r| if r.skipping { "yes" } else { "no" }.to_owned()),
    number("skipping_gain", "gain of skipping", |r| short(r.skipping_gain)),
    secondary(number("skipping_gain_iqr", "its IQR", |r| short(r.skipping_gain_iqr))),
    secondary(number("empty_macrocells", "empty macrocells", |r| fixed(r.empty_macrocells, 3))),
    secondary(number("skipping_mismatches", "pixels that skipping changes", |r| {
        count(r.skipping_mismatches)
    })),
    secondary(number("macrocell_seconds", "ranges of macrocells, s", |r| short(r.macrocell_seconds))),
    secondary(number("voxels", "voxels", |r| r.voxels.to_string())),
    secondary(number("frames", "frames", |r| r.frames.to_string())),
    secondary(number("first_frame", "first drawn", |r| r.first_frame.to_string())),
    secondary(number("last_frame", "last drawn", |r| r.last_frame.to_string())),
    secondary(file("frame_figures", "figures of frames", |r| &r.frame_figures)),
    secondary(file("error_histogram", "histogram of errors", |r| &r.error_histogram)),
    secondary(number("parity_mismatches", "parity mismatches", |r| {
        if r.shader_not_run() { SHADER_NOT_RUN.to_owned() } else { count(r.parity_mismatches) }
    })),
    secondary(number("replaced_samples", "replaced samples", |r| r.replaced_samples.to_string())),
    secondary(Column { text: Text::Series, ..text("series", "curve", |_| String::new()) }),
    secondary(text("device", "device", |r| r.device.clone())),
    secondary(text("driver", "driver", |r| r.driver.clone())),
    text("error", "error", |r| some(&r.error)),
    secondary(text("notes", "notes", |r| some(&r.notes))),
];

/// All columns.
fn columns() -> Vec<Column> {
    let listed = metrics::figures().filter(|figure| is_listed(figure.name)).map(|figure| Column {
        field: figure.name,
        heading: figure.heading,
        numeric: true,
        secondary: true,
        axis: Some(figure.axis),
        text: Text::Figure,
    });
    let speed = COLUMNS.iter().position(|c| c.field == "relative_frame_time").unwrap_or(COLUMNS.len());
    let (before, behind) = COLUMNS.split_at(speed);
    before.iter().copied().chain(listed).chain(behind.iter().copied()).collect()
}

/// Columns that can be an axis of a chart, as (field, name and unit): every column of numbers.
pub(super) fn quantities() -> impl Iterator<Item = (&'static str, &'static str)> {
    columns().into_iter().filter(|c| c.numeric).map(|c| (c.field, c.axis.unwrap_or(c.heading)))
}

/// The table as the template reads it.
pub(super) fn table(records: &[Record], labels: &Labels) -> Value {
    let class = |c: &Column| match (c.numeric, c.secondary) {
        (true, true) => "n secondary",
        (true, false) => "n",
        (false, true) => "secondary",
        (false, false) => "",
    };
    let all = columns();
    let columns: Vec<Value> =
        all.iter().map(|c| context! { field => c.field, heading => c.heading, class => class(c) }).collect();
    let row = |record: &Record| {
        let cell = |c: &Column| {
            let text = c.text(record, labels);
            context! { text => text, whole => c.whole(record), class => class(c), link => c.link(record) }
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

    use crate::experiment::results::tests::record;

    #[test]
    fn no_field_of_a_record_is_forgotten() {
        let json = serde_json::to_value(record("v", "raw")).unwrap();
        let shown: Vec<&str> = columns().iter().map(|c| c.field).collect();
        for field in json.as_object().unwrap().keys() {
            let picture = ["image", "error_image"].contains(&field.as_str());
            assert_eq!(shown.iter().filter(|s| *s == field).count(), usize::from(!picture), "{field}");
        }
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
            let column = all.iter().find(|c| c.field == figure.name).unwrap();
            assert_eq!((column.heading, column.axis), (figure.heading, Some(figure.axis)));
        }
    }

    #[test]
    fn settings_that_differ_are_shown_and_all_are_told() {
        let with = |settings: &str| Record { settings: settings.into(), ..record("v", "vq") };
        let cells = [with("block=2 seed=1"), with("block=4 seed=1")];
        let labels = Labels::of(&cells);
        let column = columns().into_iter().find(|c| c.field == "settings").unwrap();
        assert_eq!(column.text(&cells[1], &labels), "block=4");
        assert_eq!(column.whole(&cells[1]).as_deref(), Some("block=4 seed=1"));
        assert_eq!(column.text(&cells[1], &Labels::of(&cells[1..])), NONE);
        assert_eq!(column.whole(&record("v", "raw")), None);
        let shared = table(&cells, &labels).get_attr("shared").unwrap().get_item_by_index(0).unwrap();
        assert_eq!(shared.get_attr("settings").unwrap().as_str(), Some("seed=1"));
    }

    #[test]
    fn files_below_the_report_are_linked_and_no_others() {
        let column = columns().into_iter().find(|c| c.field == "error_histogram").unwrap();
        let link = |path: &str| {
            column.link(&Record { error_histogram: Some(path.to_owned()), ..record("v", "raw") })
        };
        assert_eq!(link("errors/a.csv").as_deref(), Some("errors/a.csv"));
        assert_eq!(link("javascript:alert(1)"), None);
        assert_eq!(column.link(&record("v", "raw")), None);
    }
}
