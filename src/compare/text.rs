//! The comparison as a person reads it at a terminal.

use std::fmt::Write;

use comfy_table::{CellAlignment, Table, presets};

use super::cells::{Matched, Pairing, pair};
use super::quantity::{Compared, Kind, QUANTITIES, Quantity, Verdict};
use super::side::Side;
use crate::experiment::records::labels::Labels;
use crate::experiment::records::record::{Record, Status};

/// All runs against the first.
#[must_use]
pub fn text(sides: &[Side], once: f64) -> String {
    let mut out = String::new();
    for (i, side) in sides.iter().enumerate() {
        let Side { file, machine, software, date, cells, .. } = side;
        let _ = writeln!(out, "{}  {}", letter(i), file.display());
        let _ = writeln!(out, "   {software}, {date}, {} cells\n   {machine}", cells.len());
    }
    if sides.iter().any(|s| s.scenes_by_name) {
        out += "\nA configuration is from another version: scenes are matched by name only.\n";
    }
    let Some((first, others)) = sides.split_first() else { return out };
    for (i, other) in others.iter().enumerate() {
        let pairing = pair(first, other);
        section(&mut out, &pairing, [letter(0), letter(i + 1)], once);
    }
    out
}

/// Name of a run.
pub(super) fn letter(i: usize) -> String {
    match u8::try_from(i) {
        Ok(i) if i < 26 => char::from(b'A' + i).to_string(),
        _ => format!("#{}", i + 1),
    }
}

fn section(out: &mut String, pairing: &Pairing<'_>, [a, b]: [String; 2], once: f64) {
    let Pairing { both, failed, only_first, only_other } = pairing;
    let names = Naming::of(&pairing.records());
    let _ = writeln!(out, "\n{b} against {a}: {} cells in both", both.len() + failed.len());
    if !both.is_empty() {
        if !names.shared.is_empty() {
            let _ = writeln!(out, "all of them: {}", names.shared);
        }
        let quantities: Vec<&Quantity> =
            QUANTITIES.iter().filter(|q| both.iter().any(|m| compare(q, m, once).is_some())).collect();
        let _ = writeln!(out, "\n{b} ÷ {a}, for decibels {b} − {a}; tie: within noise\n");
        let _ = writeln!(out, "{}", cells(both, &quantities, &names, once));
        let _ = writeln!(
            out,
            "\nBy codec and method: geometric mean of {b} ÷ {a}, ×÷ its spread, and cells less·tie·more\n"
        );
        let _ = writeln!(out, "{}", curves(both, &quantities, &names.labels, once));
        out.push('\n');
        for quantity in &quantities {
            let _ = writeln!(out, "{}", sentence(quantity, both, [&a, &b], once));
        }
        let percent = 100.0 * once;
        let _ = writeln!(
            out,
            "\nNoise: of frame times half the interquartile ranges of both runs (a tie: their middle halves overlap); of times\n\
             taken once (encode, decode, on device) {percent} %, see --noise; of sizes none; of decibels 0.005."
        );
    }
    list(out, &format!("only in {a}"), only_first.iter().map(|r| names.name(r)).collect());
    list(out, &format!("only in {b}"), only_other.iter().map(|r| names.name(r)).collect());
    let why = |m: &Matched<'_>| {
        let ran = |r: &Record| match r.status {
            Status::Ok => "ok".to_owned(),
            Status::Failed => format!("failed: {}", r.error.as_deref().unwrap_or("no reason given")),
        };
        format!("{}\n    {a} {}\n    {b} {}", names.name(m.first), ran(m.first), ran(m.other))
    };
    list(out, "failed in one or both, and not compared", failed.iter().map(why).collect());
}

pub(super) fn compare(quantity: &Quantity, matched: &Matched<'_>, once: f64) -> Option<Compared> {
    quantity.compare(matched.first, matched.other, once)
}

fn list(out: &mut String, what: &str, lines: Vec<String>) {
    if lines.is_empty() {
        return;
    }
    let _ = writeln!(out, "\n{} {} {what}:", lines.len(), if lines.len() == 1 { "cell" } else { "cells" });
    for line in lines {
        let _ = writeln!(out, "  {line}");
    }
}

/// Names of cells without what they all share, and without settings that all cells of their codec share.
pub(super) struct Naming {
    varies: [bool; 10],
    labels: Labels,
    shared: String,
}

impl Naming {
    pub(super) fn of(records: &[&Record]) -> Self {
        let parts: Vec<[String; 10]> = records.iter().map(|r| parts(r)).collect();
        let varies = std::array::from_fn(|i| {
            // A name says at least what was coded, and by what.
            i < 3 || parts.iter().any(|p| p[i] != parts[0][i])
        });
        let first = parts.first().cloned().unwrap_or_default();
        let shared = first.into_iter().zip(varies).filter(|(part, varies)| !varies && !part.is_empty());
        let labels = Labels::of(records.iter().copied());
        Self { varies, labels, shared: shared.map(|(part, _)| part).collect::<Vec<_>>().join(", ") }
    }

    /// What curves are called among these cells.
    pub(super) const fn labels(&self) -> &Labels {
        &self.labels
    }

    /// What all of these cells share.
    pub(super) fn shared(&self) -> &str {
        &self.shared
    }

    pub(super) fn name(&self, record: &Record) -> String {
        let [volume, codec, _, rest @ ..] = parts(record);
        let mut name = format!("{volume} {codec} {}", self.labels.settings(record)).trim_end().to_owned();
        for (part, _) in
            rest.into_iter().zip(&self.varies[3..]).filter(|(part, varies)| **varies && !part.is_empty())
        {
            name += &format!(", {part}");
        }
        name
    }
}

fn parts(r: &Record) -> [String; 10] {
    let stages = r.stages.map(|s| format!("stages {s}")).unwrap_or_default();
    let resolution = if r.resolution > 0 { format!("resolution {}", r.resolution) } else { String::new() };
    let skipping = if r.skipping { "skipping" } else { "" }.to_owned();
    let names =
        [&r.volume, &r.codec, &r.settings, &r.site, &r.filter, &r.renderer, &r.scene].map(Clone::clone);
    let [volume, codec, settings, site, filter, renderer, scene] = names;
    [volume, codec, settings, site, filter, renderer, scene, skipping, stages, resolution]
}

fn table(header: Vec<String>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(header);
    for (i, column) in table.column_iter_mut().enumerate() {
        column.set_padding((u16::from(i > 0) * 2, 0));
        if i > 0 {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

/// Lines of a table without the spaces that fill its last column.
fn lines(table: &Table) -> String {
    table.lines().map(|line| line.trim_end().to_owned()).collect::<Vec<_>>().join("\n")
}

fn cells(both: &[Matched<'_>], quantities: &[&Quantity], names: &Naming, once: f64) -> String {
    let header = std::iter::once("cell".to_owned()).chain(quantities.iter().map(|q| q.name.to_owned()));
    let mut table = table(header.collect());
    for matched in both {
        let value = |q: &&Quantity| match compare(q, matched, once) {
            None => "–".to_owned(),
            Some(c) if c.verdict == Verdict::Tie => "tie".to_owned(),
            Some(c) => change(q.kind, c.change),
        };
        let row = std::iter::once(names.name(matched.first)).chain(quantities.iter().map(value));
        table.add_row(row.collect::<Vec<_>>());
    }
    lines(&table)
}

pub(super) fn change(kind: Kind, value: f64) -> String {
    match kind {
        Kind::Decibels => format!("{value:+.2}"),
        _ if value >= 100.0 => format!("{value:.0}"),
        _ => format!("{value:.3}"),
    }
}

/// Comparisons of one quantity, taken together.
pub(super) struct Together {
    cells: usize,
    /// Geometric mean of ratios, or mean of finite differences.
    mean: f64,
    /// Geometric standard deviation (1 and more), or standard deviation.
    spread: f64,
    /// Cells that are less, tie, more.
    pub(super) verdicts: [usize; 3],
}

pub(super) fn together(quantity: &Quantity, both: &[&Matched<'_>], once: f64) -> Option<Together> {
    let all: Vec<Compared> = both.iter().filter_map(|m| compare(quantity, m, once)).collect();
    let ratio = quantity.kind != Kind::Decibels;
    let values = all.iter().map(|c| if ratio { c.change.ln() } else { c.change });
    let values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    if all.is_empty() {
        return None;
    }
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let spread = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt();
    let count = |v: Verdict| all.iter().filter(|c| c.verdict == v).count();
    let (mean, spread) = if ratio { (mean.exp(), spread.exp()) } else { (mean, spread) };
    let verdicts = [Verdict::Less, Verdict::Tie, Verdict::More].map(count);
    Some(Together { cells: all.len(), mean, spread, verdicts })
}

/// Matched cells by series, in the order of the first of each.
pub(super) fn by_series<'m, 'a>(
    both: &'m [Matched<'a>],
    labels: &Labels,
) -> Vec<(String, Vec<&'m Matched<'a>>)> {
    let mut all: Vec<(String, Vec<&Matched<'_>>)> = Vec::new();
    for matched in both {
        let series = labels.series(matched.first);
        match all.iter_mut().find(|(name, _)| *name == series) {
            Some((_, own)) => own.push(matched),
            None => all.push((series, vec![matched])),
        }
    }
    all
}

fn curves(both: &[Matched<'_>], quantities: &[&Quantity], labels: &Labels, once: f64) -> String {
    let header = ["codec".to_owned(), "cells".to_owned()];
    let mut table = table(header.into_iter().chain(quantities.iter().map(|q| q.name.to_owned())).collect());
    for (series, own) in by_series(both, labels) {
        let value = |q: &&Quantity| match together(q, &own, once) {
            None => "–".to_owned(),
            Some(Together { verdicts: [0, _, 0], .. }) => "tie".to_owned(),
            Some(t) => {
                let [less, tie, more] = t.verdicts;
                format!("{}\n{less}·{tie}·{more}", mean(q.kind, &t))
            }
        };
        let row = [series, own.len().to_string()].into_iter().chain(quantities.iter().map(value));
        table.add_row(row.collect::<Vec<_>>());
    }
    lines(&table)
}

pub(super) fn mean(kind: Kind, t: &Together) -> String {
    let value = change(kind, t.mean);
    match kind {
        _ if t.cells < 2 => value,
        Kind::Decibels => format!("{value} ± {:.2}", t.spread),
        _ => format!("{value} ×÷ {:.2}", t.spread),
    }
}

pub(super) fn sentence(quantity: &Quantity, both: &[Matched<'_>], [a, b]: [&str; 2], once: f64) -> String {
    let all: Vec<&Matched<'_>> = both.iter().collect();
    let Some(t) = together(quantity, &all, once) else { return String::new() };
    let (cells, [less, tie, more]) = (t.cells, t.verdicts);
    let field = quantity.field;
    if tie == cells {
        return format!("{field}: {a} and {b} tie in all {cells} cells");
    }
    let value = mean(quantity.kind, &t);
    let counts = format!("{less} less, {tie} tie, {more} more");
    match quantity.kind {
        Kind::Decibels => format!("{field}: {b} is {value} dB against {a} over {cells} cells: {counts}"),
        Kind::Once if t.spread > 1.0 + 2.0 * once => format!(
            "{field}: {b} is {value} times {a} over {cells} cells: {counts}; the ratios disagree by more than the noise of \
             --noise: a single cell means little"
        ),
        _ => format!("{field}: {b} is {value} times {a} over {cells} cells: {counts}"),
    }
}
