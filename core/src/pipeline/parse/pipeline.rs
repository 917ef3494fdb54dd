//! `[pipeline]`: axes that every renderer has, and settings of the named renderers.

use std::collections::HashSet;

use super::super::config::{PipelineAxes, Sweep};
use super::super::document::{Entry, Node, Value};
use super::super::keys::{self, ALL_STAGES, MOST_RESOLUTION, MOST_STAGES};
use super::super::read::Fields;
use super::{Known, settings};
use crate::codec::{Setting, Site};
use crate::diagnostic::Diagnostic;
use crate::render::{Filter, RendererInfo};

const STAGES: &str = "an integer from 1 to 254, or \"all\"";
const RESOLUTION: &str = "an integer from 0 to 32";

/// `max_cells` bounds the number of combinations of a renderer's settings.
pub(super) fn read(
    node: &Node,
    known: &Known<'_>,
    max_cells: u64,
    notes: &mut Vec<String>,
) -> Result<PipelineAxes, Diagnostic> {
    let fields = Fields::open("the pipeline", node)?;
    let named = match fields.get("renderer") {
        Some(node) => named(node, known)?,
        // Without `renderer`, only a mistyped key is reported before the missing one.
        None => known.renderers.to_vec(),
    };
    check_keys(&fields, &named, known)?;
    fields.require("renderer", "renderer = [\"raycasting\"]")?;
    let mut renderers = Vec::new();
    let mut seen = HashSet::new();
    for info in named {
        for label in labels(&fields, info, max_cells, notes)? {
            if seen.insert(label.clone()) {
                renderers.push(label);
            }
        }
    }
    let sites = Site::ALL.map(|site| (site.name(), site));
    let filters = Filter::ALL.map(|filter| (filter.name(), filter));
    let skipping = fields.optional("skipping", |n| n.one_or_many("value of skipping", Node::boolean))?;
    let stages = fields.optional("stages", |n| n.one_or_many("number of stages", stages))?;
    let resolutions = fields.optional("resolution", |n| n.one_or_many("resolution", resolution))?;
    Ok(PipelineAxes {
        renderers,
        sites: fields
            .require("site", "site = [\"inline\", \"host\"]")?
            .one_or_many("site", |n| n.one_of("site", &sites))?,
        filters: fields
            .require("filter", "filter = [\"nearest\", \"linear\"]")?
            .one_or_many("filter", |n| n.one_of("filter", &filters))?,
        skipping: skipping.unwrap_or_else(|| vec![false]),
        stages: stages.unwrap_or_else(|| vec![None]),
        resolutions: resolutions.unwrap_or_else(|| vec![0]),
    })
}

/// Number of stages to decode. `None` for all.
fn stages(node: &Node) -> Result<Option<u8>, Diagnostic> {
    match &node.value {
        Value::Text(text) if text == ALL_STAGES => Ok(None),
        Value::Text(_) => Err(node.not_allowed(STAGES)),
        _ => Ok(u8::try_from(node.integer(1, MOST_STAGES, STAGES)?).ok()),
    }
}

/// Which resolution is decoded; 0 is the full one.
fn resolution(node: &Node) -> Result<u8, Diagnostic> {
    let number = node.integer(0, MOST_RESOLUTION, RESOLUTION)?;
    u8::try_from(number).map_err(|_| node.not_allowed(RESOLUTION))
}

/// The renderers of the key `renderer`.
fn named(node: &Node, known: &Known<'_>) -> Result<Vec<&'static RendererInfo>, Diagnostic> {
    let ids: Vec<(&str, &str)> = known.renderers.iter().map(|info| (info.id, info.id)).collect();
    let named = node.one_or_many("renderer", |n| n.one_of("renderer", &ids))?;
    let is_named = |id: &str| known.renderers.iter().copied().find(|info| info.id == id);
    Ok(named.into_iter().filter_map(is_named).collect())
}

/// Refuses the first key that belongs neither to the pipeline nor to a named renderer.
fn check_keys(
    fields: &Fields<'_>,
    named: &[&'static RendererInfo],
    known: &Known<'_>,
) -> Result<(), Diagnostic> {
    let axes = keys::axes(Vec::new());
    let mut keys: Vec<&str> = axes.iter().map(|key| key.name.as_str()).collect();
    for setting in named.iter().flat_map(|info| info.settings) {
        if !keys.contains(&setting.name) {
            keys.push(setting.name);
        }
    }
    let Some(entry) = fields.entries().iter().find(|entry| !keys.contains(&entry.key.as_str())) else {
        return Ok(());
    };
    let mut error = fields.unknown_key(entry, &keys);
    let others = known.renderers.iter().filter(|info| setting_of(info, entry).is_some());
    for info in others {
        error = error.with_note(format!("renderer `{}` has it, and is not named in `renderer`", info.id));
    }
    Err(error)
}

fn setting_of<'a>(info: &'a RendererInfo, entry: &Entry) -> Option<&'a Setting> {
    info.settings.iter().find(|setting| setting.name == entry.key)
}

/// The labels of a renderer under all values of its settings in the configuration.
fn labels(
    fields: &Fields<'_>,
    info: &RendererInfo,
    max_cells: u64,
    notes: &mut Vec<String>,
) -> Result<Vec<String>, Diagnostic> {
    let owner = format!("renderer `{}`", info.id);
    let written = fields.entries().iter().filter_map(|entry| Some((entry, setting_of(info, entry)?)));
    let sweeps = written.map(|(entry, setting)| settings::sweep(entry, setting, &owner, notes));
    let sweeps: Vec<Sweep> = sweeps.collect::<Result<_, _>>()?;
    let cells = Sweep::count(&sweeps);
    if cells > u128::from(max_cells) {
        let message =
            format!("the settings of {owner} alone make {cells} cells, and {max_cells} are allowed");
        return Err(fields.error(message, "in this table").with_note(super::FEWER_CELLS));
    }
    let label = |settings| info.label(&settings).map_err(|e| fields.error(e.to_string(), "in this table"));
    Sweep::combinations(&sweeps).into_iter().map(label).collect()
}
