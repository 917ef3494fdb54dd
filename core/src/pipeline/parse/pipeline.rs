//! `[pipeline]`

use super::super::config::PipelineAxes;
use super::super::document::Node;
use super::super::read::Fields;
use super::Known;
use crate::codec::Site;
use crate::diagnostic::Diagnostic;
use crate::render::Filter;

pub(super) fn read(node: &Node, known: &Known<'_>) -> Result<PipelineAxes, Diagnostic> {
    let fields = Fields::of("the pipeline", node, &["renderer", "site", "filter"])?;
    let renderers: Vec<(&str, String)> = known.renderers.iter().map(|r| (r.id, r.id.to_owned())).collect();
    let sites = Site::ALL.map(|site| (site.name(), site));
    let filters = Filter::ALL.map(|filter| (filter.name(), filter));
    Ok(PipelineAxes {
        renderers: fields
            .require("renderer", "renderer = [\"raycasting\"]")?
            .one_or_many("renderer", |n| n.one_of("renderer", &renderers))?,
        sites: fields
            .require("site", "site = [\"inline\", \"host\"]")?
            .one_or_many("site", |n| n.one_of("site", &sites))?,
        filters: fields
            .require("filter", "filter = [\"nearest\", \"linear\"]")?
            .one_or_many("filter", |n| n.one_of("filter", &filters))?,
    })
}
