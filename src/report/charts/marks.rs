//! What the charts share: colour and shape of a codec, texts of marks, and legends.

use super::super::cells::{Baseline, blends, compressed, distinct, ok};
use super::super::chart::{Colour, LegendEntry, Line, Mark, Point, Shape};
use super::super::number::{bytes, decibels, fixed, short};
use super::super::pareto;
use crate::experiment::records::labels::{Labels, full_coding};
use crate::experiment::records::record::Record;

/// Which colour and shape a series has throughout the report, and what cells are called there.
#[derive(Debug)]
pub(in super::super) struct Palette {
    pub(in super::super) labels: Labels,
    series: Vec<String>,
    /// Series and sites.
    sites: Vec<(String, String)>,
}

impl Palette {
    /// The uncompressed codec comes first whether it is there or not, so that others keep their colours.
    pub(in super::super) fn new(records: &[Record]) -> Self {
        let labels = Labels::of(records);
        let compressed = records.iter().filter(|r| compressed(r)).map(|r| labels.series(r));
        let series = distinct(std::iter::once("raw".to_owned()).chain(compressed));
        let sites = distinct(records.iter().map(|r| (labels.series(r), r.site.clone())));
        Self { labels, series, sites }
    }

    /// The colour of a series, by its name.
    pub(super) fn colour(&self, series: &str) -> Colour {
        Colour::Series(self.index(series))
    }

    fn index(&self, series: &str) -> usize {
        self.series.iter().position(|s| s == series).unwrap_or(0)
    }

    /// The mark of a series, by its name.
    pub(super) fn mark(&self, series: &str) -> Mark {
        Mark::filled(shape(self.index(series)), self.colour(series))
    }

    /// The mark of a record's series.
    pub(super) fn mark_of(&self, record: &Record) -> Mark {
        self.mark(&self.labels.series(record))
    }

    /// The mark of a record's series at its site.
    pub(in super::super) fn site_mark(&self, record: &Record) -> Mark {
        let series = self.labels.series(record);
        let at = self.sites.iter().position(|(own, site)| *own == series && *site == record.site);
        Mark::filled(shape(at.unwrap_or(0)), self.colour(&series))
    }

    /// One entry for each series of these cells.
    pub(super) fn series_entries(&self, cells: &[&Record]) -> Vec<LegendEntry> {
        let series = distinct(cells.iter().map(|r| self.labels.series(r)));
        series.into_iter().map(|label| LegendEntry { mark: self.mark(&label), label }).collect()
    }
}

/// Colours repeat after eight; shapes then begin one later, so that no two of 64 series share both.
const fn shape(i: usize) -> Shape {
    Shape::series(i + i / Colour::PALETTE)
}

/// Text of a chart's point.
pub(super) fn title(record: &Record, palette: &Palette) -> String {
    let mut title = format!(
        "{}\n{} bits per voxel, PSNR {}, picture {}, SSIM {}",
        palette.labels.cell(record),
        short(record.bits_per_voxel),
        decibels(record.psnr_db),
        decibels(record.image_psnr_db),
        fixed(record.image_ssim, 4)
    );
    if record.encode_seconds.is_some() || record.decode_seconds.is_some() {
        let [encode, decode] = [record.encode_seconds, record.decode_seconds].map(short);
        title += &format!("\nencoded in {encode} s, decoded on the CPU in {decode} s");
    }
    if let Some(memory) = record.resident_bytes {
        title += &format!("\n{} in device memory", bytes(Some(memory)));
        if let Some(peak) = record.device_decode_bytes {
            title += &format!(", {} while decoding", bytes(Some(peak)));
        }
    }
    if record.relative_frame_time.is_some() {
        title += &format!(
            "\nframe {} ms (IQR {}), {} × the baseline",
            short(record.frame_ms),
            short(record.frame_ms_iqr),
            short(record.relative_frame_time)
        );
    }
    if !ok(record) {
        title += &format!("\nFAILED: {}", record.error.as_deref().unwrap_or("no reason given"));
    }
    title
}

/// A record's number among all.
pub(super) fn number(records: &[Record], record: &Record) -> usize {
    records.iter().position(|r| std::ptr::eq(r, record)).unwrap_or(0)
}

/// One cell for each codec, settings and number of stages, if cells share the measurement. It counts as failed only if all did.
pub(super) fn one_per_coding<'a>(cells: &[&'a Record]) -> Vec<&'a Record> {
    let one = |name: String| {
        let same = || cells.iter().copied().filter(|r| full_coding(r) == name);
        same().find(|r| ok(r)).or_else(|| same().next())
    };
    distinct(cells.iter().map(|r| full_coding(r))).into_iter().filter_map(one).collect()
}

/// A cell in a chart of one quantity against another.
pub(super) struct Placed<'a> {
    pub(super) record: &'a Record,
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) mark: Mark,
}

/// Marks of competing cells, with unbeaten ones on top and the others grey, and the line along the unbeaten ones. `costs`
/// returns the quantities to minimise. A failed cell does not compete.
pub(super) fn contest(
    records: &[Record],
    palette: &Palette,
    cells: &[Placed<'_>],
    costs: fn(f64, f64) -> (f64, f64),
) -> (Vec<Point>, Line) {
    let competing: Vec<&Placed<'_>> = cells.iter().filter(|p| ok(p.record)).collect();
    let front = pareto::front(&competing.iter().map(|p| costs(p.x, p.y)).collect::<Vec<_>>());
    let best: Vec<&Placed<'_>> = front.into_iter().map(|i| competing[i]).collect();
    let mut points: Vec<Point> = cells
        .iter()
        .map(|placed| {
            let Placed { record, x, y, mark } = placed;
            let unbeaten = best.iter().any(|b| std::ptr::eq(*b, placed));
            let mark = if ok(record) { Mark { faint: !unbeaten, ..*mark } } else { Mark::failure() };
            let (title, cell) = (title(record, palette), Some(number(records, record)));
            Point { x: *x, y: *y, mark, title, cell, unbeaten }
        })
        .collect();
    points.sort_by_key(|p| (p.mark == Mark::failure(), p.unbeaten));
    let line = Line { points: best.iter().map(|p| (p.x, p.y)).collect(), colour: Colour::Ink, dashed: false };
    (points, line)
}

/// Meaning of a cross, if there is one.
pub(super) fn failure_entries(points: &[Point]) -> Vec<LegendEntry> {
    points.iter().find(|p| p.mark == Mark::failure()).map(|_| failure_entry()).into_iter().collect()
}

pub(in super::super) fn failure_entry() -> LegendEntry {
    LegendEntry { mark: Mark::failure(), label: "failed".to_owned() }
}

/// What grey means, where anything is.
pub(super) fn beaten_entries(points: &[Point]) -> Vec<LegendEntry> {
    let mark = Mark { faint: true, ..Mark::filled(Shape::Circle, Colour::Ink) };
    let entry = || LegendEntry { mark, label: "grey: another is at least as good in both".to_owned() };
    points.iter().find(|p| p.mark.faint).map(|_| entry()).into_iter().collect()
}

/// What filled and hollow mean, where both occur.
pub(in super::super) fn filter_entries(cells: &[&Record], shape: Shape) -> Vec<LegendEntry> {
    let both = cells.iter().any(|r| blends(r)) && cells.iter().any(|r| !blends(r));
    if both { filled_and_hollow(shape, "linear filter", "nearest") } else { Vec::new() }
}

/// Two entries: filled and hollow marks.
pub(super) fn filled_and_hollow(shape: Shape, filled: &str, hollow: &str) -> Vec<LegendEntry> {
    let entry = |filled, label: &str| {
        let mark = Mark { filled, ..Mark::filled(shape, Colour::Ink) };
        LegendEntry { mark, label: label.to_owned() }
    };
    vec![entry(true, filled), entry(false, hollow)]
}

/// One entry for each series at each site of these cells, baselines left out.
pub(super) fn site_entries(palette: &Palette, cells: &[&Record]) -> Vec<LegendEntry> {
    let named = |r: &Record| (palette.labels.series(r), r.site.clone());
    let series = distinct(cells.iter().map(|r| named(r)));
    let entry = |own: (String, String)| {
        let plain = |r: &&&Record| named(r) == own && ok(r) && Baseline::of(r).is_none();
        let mark = palette.site_mark(cells.iter().find(plain)?);
        Some(LegendEntry { mark, label: format!("{}, {}", own.0, own.1) })
    };
    series.into_iter().filter_map(entry).collect()
}

/// The mark of a baseline: a letter in a ring.
pub(in super::super) fn baseline_mark(baseline: Baseline) -> Mark {
    Mark { filled: false, ..Mark::filled(Shape::Letter(baseline.letter()), Colour::Ink) }
}

/// Meanings of the baselines' letters among these cells.
pub(super) fn baseline_entries(cells: &[&Record]) -> Vec<LegendEntry> {
    let there = |b: &Baseline| cells.iter().any(|r| ok(r) && Baseline::of(r) == Some(*b));
    let entry = |b| LegendEntry { mark: baseline_mark(b), label: b.label().to_owned() };
    [Baseline::Texture, Baseline::Buffer].into_iter().filter(there).map(entry).collect()
}
