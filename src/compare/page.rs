//! The comparison as a page: one HTML file that reads without a network and without scripts, in the report's style.

use minijinja::{AutoEscape, Environment, Value, context};

use super::cells::{Matched, Pairing, pair};
use super::quantity::{Compared, Kind, QUANTITIES, Quantity, Verdict};
use super::side::Side;
use super::text::{Naming, Together, by_series, change, compare, letter, mean, sentence, together};
use crate::experiment::records::labels::full_cell;
use crate::experiment::records::record::{Record, Status};
use crate::report::STYLE;

const TEMPLATE: &str = include_str!("template.html");

/// All runs against the first. `once` as [`Quantity::compare`] has it.
///
/// # Errors
/// When the page's template fails.
pub fn page(sides: &[Side], once: f64) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_template("compare", TEMPLATE)?;
    let runs: Vec<Value> = sides.iter().enumerate().map(|(i, side)| run(i, side)).collect();
    let pairs: Vec<Value> = match sides.split_first() {
        None => Vec::new(),
        Some((first, others)) => {
            let of = |(i, other)| section(&pair(first, other), [letter(0), letter(i + 1)], once);
            others.iter().enumerate().map(of).collect()
        }
    };
    let context = context! {
        style => Value::from_safe_string(STYLE.to_owned()),
        runs => runs,
        by_name => sides.iter().any(|side| side.scenes_by_name),
        pairs => pairs,
        noise => 100.0 * once,
    };
    environment.get_template("compare")?.render(context)
}

fn run(i: usize, side: &Side) -> Value {
    let Side { file, machine, software, date, cells, .. } = side;
    context! {
        letter => letter(i),
        file => file.display().to_string(),
        machine => machine,
        software => software,
        date => date,
        cells => cells.len(),
    }
}

fn section(pairing: &Pairing<'_>, [a, b]: [String; 2], once: f64) -> Value {
    let Pairing { both, failed, only_first, only_other } = pairing;
    let names = Naming::of(&pairing.records());
    let quantities: Vec<&Quantity> =
        QUANTITIES.iter().filter(|q| both.iter().any(|m| compare(q, m, once).is_some())).collect();
    let row = |m: &Matched<'_>| {
        let values: Vec<Value> = quantities.iter().map(|q| value(q, compare(q, m, once), [&a, &b])).collect();
        context! { name => names.name(m.first), full => full_cell(m.first), values => values }
    };
    let series = |(series, own): (String, Vec<&Matched<'_>>)| {
        let values: Vec<Value> =
            quantities.iter().map(|q| together_value(q, together(q, &own, once))).collect();
        context! { name => series, cells => own.len(), values => values }
    };
    let named = |cells: &[&Record]| cells.iter().map(|r| names.name(r)).collect::<Vec<_>>();
    let why = |m: &Matched<'_>| {
        let ran = |r: &Record| match r.status {
            Status::Ok => "ok".to_owned(),
            Status::Failed => format!("failed: {}", r.error.as_deref().unwrap_or("no reason given")),
        };
        format!("{}: {a} {}; {b} {}", names.name(m.first), ran(m.first), ran(m.other))
    };
    let lists = [
        (format!("only in {a}"), named(only_first)),
        (format!("only in {b}"), named(only_other)),
        ("failed in one or both, and not compared".to_owned(), failed.iter().map(why).collect()),
    ];
    let lists = lists.into_iter().filter(|(_, lines)| !lines.is_empty());
    let lists: Vec<Value> = lists.map(|(what, lines)| context! { what => what, lines => lines }).collect();
    context! {
        a => a.clone(),
        b => b.clone(),
        count => both.len() + failed.len(),
        shared => names.shared(),
        quantities => quantities.iter().map(|q| context! { name => q.name, field => q.field }).collect::<Vec<_>>(),
        sentences => quantities.iter().map(|q| sentence(q, both, [&a, &b], once)).collect::<Vec<_>>(),
        series => by_series(both, names.labels()).into_iter().map(series).collect::<Vec<_>>(),
        rows => both.iter().map(row).collect::<Vec<_>>(),
        lists => lists,
    }
}

/// Whether a change is an improvement: more decibels, less of anything else.
const fn class(quantity: &Quantity, verdict: Verdict) -> &'static str {
    match (verdict, matches!(quantity.kind, Kind::Decibels)) {
        (Verdict::Tie, _) => "tie",
        (Verdict::Less, false) | (Verdict::More, true) => "better",
        (Verdict::Less, true) | (Verdict::More, false) => "worse",
    }
}

fn value(quantity: &Quantity, compared: Option<Compared>, [a, b]: [&str; 2]) -> Value {
    let Some(c) = compared else { return context! { text => "–" } };
    let told = change(quantity.kind, c.change);
    let text = if c.verdict == Verdict::Tie { "tie".to_owned() } else { told.clone() };
    let whole = format!("{a} {}, {b} {}: {told}, noise {:.3}", c.first, c.other, c.noise);
    context! { text => text, class => class(quantity, c.verdict), whole => whole }
}

fn together_value(quantity: &Quantity, all: Option<Together>) -> Value {
    let Some(t) = all else { return context! { text => "–" } };
    let [less, tie, more] = t.verdicts;
    let verdict = match (less > 0, more > 0) {
        (false, false) => return context! { text => "tie", class => "tie" },
        (true, false) => Verdict::Less,
        (false, true) => Verdict::More,
        // Some cells are less and some more: neither colour would be true.
        (true, true) => Verdict::Tie,
    };
    let counts = format!("{less} less, {tie} tie, {more} more");
    context! { text => mean(quantity.kind, &t), class => class(quantity, verdict), counts => counts }
}
