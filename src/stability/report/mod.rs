//! `atlas.html`: one page that holds the heat map, a curve per dial, breaking points, encoders and the worst pictures.
//! `charts/` beside it holds heat map and curves as SVG.

mod curves;
mod heat_map;
mod worst;

pub(super) use worst::name as worst_name;

use cvr_core::stability::{Reason, Verdict};
use minijinja::{AutoEscape, Environment, Value, context};
use serde::Serialize;

use super::atlas::Atlas;
use super::breaking::Breaking;
use super::encoder::EncoderMeasured;
use super::plan::Plan;
use super::runner::Outcome;
use crate::experiment::files::folder::OutFolder;
use crate::experiment::files::names::CHARTS;
use crate::experiment::records::machine;
use crate::report::STYLE;

const TEMPLATE: &str = include_str!("atlas.html");

/// Where an atlas comes from.
#[derive(Clone, Debug, Serialize)]
pub struct Provenance {
    /// Version of this software.
    pub version: String,
    /// Commit that it was built from.
    pub git_hash: Option<String>,
    /// Processor.
    pub cpu: String,
    /// When.
    pub date: String,
    /// The command.
    pub command_line: String,
    /// Longest axis of the volumes, in voxels.
    pub edge: u32,
    /// Edge of the pictures, in pixels.
    pub picture: u32,
    /// Cells.
    pub cells: usize,
}

impl Provenance {
    /// Provenance of this process.
    #[must_use]
    pub fn now(plan: &Plan) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            git_hash: machine::git_hash(),
            cpu: machine::cpu(),
            date: machine::date(),
            command_line: machine::command_line(),
            edge: plan.config.edge,
            picture: plan.config.picture,
            cells: plan.cells(),
        }
    }
}

/// Writes the page, the charts and the worst pictures.
///
/// # Errors
/// A sentence, when a file cannot be written or a picture cannot be drawn.
pub fn write(
    out: &OutFolder,
    provenance: &Provenance,
    plan: &Plan,
    atlas: &Atlas,
    outcome: &Outcome,
) -> Result<(), String> {
    let heat_map = heat_map::svg(atlas);
    let file = |name: &str, text: &str| {
        out.write(&format!("{CHARTS}/{name}.svg"), text.as_bytes()).map_err(|e| e.to_string())
    };
    file("heat-map", &heat_map)?;
    let curves = curves::dials(atlas).into_iter().chain(curves::generations(&outcome.encoders));
    let curves: Vec<Value> = curves
        .map(|curve| {
            file(&curve.name, &curve.chart.svg_file(&curve.title, STYLE))?;
            let legend = curve.chart.legend.iter().map(|entry| {
                context! { sign => Value::from_safe_string(entry.mark.svg()), label => &entry.label }
            });
            Ok(context! {
                title => &curve.title,
                description => &curve.chart.description,
                svg => Value::from_safe_string(curve.chart.svg()),
                legend => legend.collect::<Vec<_>>(),
            })
        })
        .collect::<Result<_, String>>()?;
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_template("atlas", TEMPLATE).map_err(|e| e.to_string())?;
    let count = |verdict| atlas.rows.iter().filter(|r| r.verdict == verdict).count();
    let values = context! {
        style => Value::from_safe_string(STYLE.to_owned()),
        provenance => context! {
            version => &provenance.version,
            git_hash => &provenance.git_hash,
            cpu => &provenance.cpu,
            date => &provenance.date,
            command_line => &provenance.command_line,
            edge => provenance.edge,
            picture => provenance.picture,
        },
        missing => outcome.missing,
        verdicts => atlas.rows.len(),
        counts => [Verdict::Holds, Verdict::Degrades, Verdict::Fails, Verdict::Refused]
            .map(|v| context! { name => v.name(), count => count(v) })
            .to_vec(),
        colours => heat_map::LEGEND.map(|(colour, label)| context! { colour => colour, label => label }).to_vec(),
        scenes => plan.scenes.iter().map(|s| context! { name => s.name, doc => s.doc }).collect::<Vec<_>>(),
        subjects => plan.dials.iter().map(|d| {
            context! { name => d.subject.name, doc => d.subject.doc, dial => d.subject.dial }
        }).collect::<Vec<_>>(),
        heat_map => Value::from_safe_string(heat_map),
        broken => atlas.broken().map(|row| context! {
            label => &row.label, subject => &row.subject, value => row.value, problem => &row.problem,
        }).collect::<Vec<_>>(),
        breaking => atlas.breaking.iter().filter(|b| b.degrades_at.is_some() || b.refused).map(breaking_values).collect::<Vec<_>>(),
        unbroken => unbroken(atlas),
        curves => curves,
        encoders => outcome.encoders.iter().map(encoder_values).collect::<Vec<_>>(),
        worst => worst::values(out, plan, atlas)?,
    };
    let template = environment.get_template("atlas").map_err(|e| e.to_string())?;
    let page = template.render(values).map_err(|e| e.to_string())?;
    out.write("atlas.html", page.as_bytes()).map_err(|e| e.to_string())
}

/// A number as a dial shows it.
fn dial_value(value: f64) -> String {
    let plain = value == 0.0 || (1e-4..1e7).contains(&value.abs());
    if plain { value.to_string() } else { format!("{value:e}") }
}

/// For each codec, the subjects that neither break nor degrade it.
fn unbroken(atlas: &Atlas) -> Vec<Value> {
    let mut labels: Vec<&str> = atlas.breaking.iter().map(|b| b.label.as_str()).collect();
    labels.dedup();
    let of = |label: &str| {
        let own = atlas.breaking.iter().filter(|b| b.label == label && b.degrades_at.is_none() && !b.refused);
        own.map(|b| b.subject.clone()).collect::<Vec<String>>().join(", ")
    };
    labels.into_iter().map(|label| context! { label => label, subjects => of(label) }).collect()
}

fn breaking_values(b: &Breaking) -> Value {
    let value = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), dial_value);
    let fails = match b.refused {
        true => "refuses".to_owned(),
        false => value(b.fails_at),
    };
    context! {
        label => &b.label,
        subject => &b.subject,
        dial => &b.dial,
        fails => fails,
        scene => &b.fails_in,
        reason => b.fails_by.map(Reason::name),
        voxels => value(b.voxels_fail_at),
        degrades => value(b.degrades_at),
        failing => format!("{:.0} %", b.failing * 100.0),
    }
}

fn encoder_values(e: &EncoderMeasured) -> Value {
    let decibels = |v: Option<f64>| match v {
        None => "–".to_owned(),
        Some(v) => format!("{v:.2}"),
    };
    let psnr = |v: Option<&Option<f64>>| match v {
        None => "–".to_owned(),
        Some(None) => "lossless".to_owned(),
        Some(Some(v)) => format!("{v:.2}"),
    };
    context! {
        label => &e.label,
        subject => &e.subject,
        problem => &e.problem,
        seeds => e.seeds.len(),
        spread => decibels(e.spread_db()),
        threads => &e.threads,
        agree => e.threads_agree,
        first => psnr(e.generations.first()),
        last => psnr(e.generations.last()),
        loss => decibels(e.generation_loss_db()),
        generations => e.generations.len(),
    }
}
