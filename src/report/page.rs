//! The page: its parts, put into the template.

use std::path::Path;

use minijinja::{AutoEscape, Environment, Value, context};

use super::cells::volumes;
use super::chart::Mark;
use super::charts::Palette;
use super::embed::{EMBEDDED_BYTES, Pictures, link};
use super::figure::{ALL_VOLUMES, Figure};
use super::{BJONTEGAARD, ReportError, bd_table, data, pictures, script, summary, table};
use crate::experiment::files::names::CHARTS;
use crate::experiment::records::labels::Labels;
use crate::experiment::records::provenance::{Part, Provenance, RefusedCell, VolumeProvenance};
use crate::experiment::records::record::Record;

use cvr_core::metrics::ERROR_CLASSES;

const TEMPLATE: &str = include_str!("template.html");
pub(crate) const STYLE: &str = include_str!("style.css");

pub(super) fn render(
    dir: &Path,
    provenance: &Provenance,
    records: &[Record],
    refused: &[RefusedCell],
    (figures, palette): (&[Figure], &Palette),
) -> Result<String, ReportError> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_template("report", TEMPLATE)?;

    let labels = &palette.labels;
    let mut embedded = Pictures::new(dir, EMBEDDED_BYTES);
    let groups = pictures::groups(provenance, records, labels, &mut embedded);
    let context = context! {
        style => Value::from_safe_string(STYLE.to_owned()),
        summary => summary::summary(records, refused, labels),
        provenance => provenance_values(provenance),
        pictures => groups,
        linked => embedded.linked(),
        error_classes => error_classes(),
        charts => charts(records, figures),
        differences => bd_table::tables(records, labels),
        differences_file => Value::from_safe_string(link(&format!("{CHARTS}/{BJONTEGAARD}.csv"))),
        policy => script::policy(),
        script => Value::from_safe_string(script::text()),
        data => Value::from_safe_string(data::json(provenance, records, palette)),
        table => table::table(records, labels),
        refused => refused_rows(refused),
    };
    Ok(environment.get_template("report")?.render(context)?)
}

/// The legend of the error picture.
fn error_classes() -> Vec<Value> {
    let class =
        |label: &str, [r, g, b]: [u8; 3]| context! { label => label, colour => format!("rgb({r},{g},{b})") };
    let none = class("none", [0; 3]);
    std::iter::once(none).chain(ERROR_CLASSES.iter().map(|c| class(c.label, c.rgb))).collect()
}

/// One section of charts of all volumes, where there are any, and one per volume.
fn charts(records: &[Record], figures: &[Figure]) -> Vec<Value> {
    let section = |volume: Option<String>| {
        let own: Vec<Value> = figures.iter().filter(|f| f.volume == volume).map(figure).collect();
        (volume.is_some() || !own.is_empty())
            .then(|| context! { volume => volume.unwrap_or_else(|| ALL_VOLUMES.to_owned()), figures => own })
    };
    std::iter::once(None).chain(volumes(records).into_iter().map(Some)).filter_map(section).collect()
}

fn figure(figure: &Figure) -> Value {
    let Figure { name, kind, caption, wide, chart, note, .. } = figure;
    // Drawings escape what they take from records themselves.
    let mark = |mark: &Mark| Value::from_safe_string(mark.svg());
    let legend: Vec<Value> =
        chart.legend.iter().map(|e| context! { mark => mark(&e.mark), label => e.label.clone() }).collect();
    context! {
        kind => kind,
        caption => caption,
        wide => wide,
        // Nothing of an address in percent is read as HTML.
        file => Value::from_safe_string(link(&format!("{CHARTS}/{name}"))),
        description => chart.description.clone(),
        svg => Value::from_safe_string(chart.svg()),
        legend => legend,
        note => note,
    }
}

fn provenance_values(p: &Provenance) -> Value {
    let adapter = [p.adapter.as_str(), p.driver.as_str(), p.backend.as_str()];
    let adapter = adapter.into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(" · ");
    context! {
        experiment => p.experiment.clone(),
        version => p.version.clone(),
        git_hash => p.git_hash.clone(),
        adapter => adapter,
        cpu => p.cpu.clone(),
        cores => p.cores,
        seed => p.seed,
        date => p.date.clone(),
        baseline => p.baseline.clone(),
        command_line => p.command_line.clone(),
        config => p.config.clone(),
        parts => p.parts.iter().map(part_text).collect::<Vec<_>>(),
        volumes => p.volumes.iter().map(volume_values).collect::<Vec<_>>(),
    }
}

fn part_text(part: &Part) -> String {
    let Part { folder, records, adapter, driver, cpu, date, .. } = part;
    [folder, &format!("{records} cells"), adapter, driver, cpu, date].map(String::as_str).join(" · ")
}

fn volume_values(v: &VolumeProvenance) -> Value {
    let times = |values: &[String]| values.join(" × ");
    context! {
        name => v.name.clone(),
        source => v.source.clone(),
        blake3 => v.blake3.clone(),
        dims => times(&v.dims.map(|d| d.to_string())),
        dtype => v.dtype.clone(),
        spacing => times(&v.spacing.map(|s| s.to_string())),
        range => v.range.map(|r| r.to_string()).join(" … "),
    }
}

/// Rows of texts, with all settings. A row shows the settings that differ among the refused cells of its codec.
fn refused_rows(refused: &[RefusedCell]) -> Vec<Value> {
    let record = |cell: &RefusedCell| Record {
        codec: cell.codec.clone(),
        settings: cell.settings.clone(),
        ..Record::default()
    };
    let labels = Labels::of(&refused.iter().map(record).collect::<Vec<_>>());
    let row = |cell: &RefusedCell| {
        let RefusedCell {
            volume,
            codec,
            settings,
            site,
            mut filter,
            renderer,
            scene,
            skipping,
            stages,
            resolution,
            reason,
        } = cell.clone();
        if skipping {
            filter += ", skipping";
        }
        if let Some(stages) = stages {
            filter += &format!(", stages {stages}");
        }
        if resolution > 0 {
            filter += &format!(", resolution {resolution}");
        }
        let brief = labels.settings(&record(cell));
        let texts = vec![volume, codec, brief, site, filter, renderer, scene, reason];
        context! { texts => texts, settings => settings }
    };
    refused.iter().map(row).collect()
}
