//! `[[codec]]`, from the schemas that codecs bring.

use super::shape::{Key, Shape, Table};
use crate::codec::{CodecInfo, SettingKind, Site};
use crate::pipeline::Known;

/// A table for each codec.
pub(super) fn tables(known: &Known<'_>) -> Vec<(String, Table)> {
    known.codecs.iter().map(|codec| (codec.info().id.to_owned(), table(codec.info()))).collect()
}

fn table(info: &CodecInfo) -> Table {
    let id = Shape::Words(vec![(info.id.to_owned(), info.summary.to_owned())]);
    let mut keys = vec![Key::required("id", id, "The codec")];
    keys.extend(info.settings.iter().map(|setting| {
        let shape = Shape::Sweep(Box::new(Shape::Setting(setting.kind)));
        Key::with_default(setting.name, shape, written(setting.kind, setting.default), setting.doc)
    }));
    let sites: Vec<&str> = info.offered().map(Site::name).collect();
    let filter = if info.fetch_cell { "; filter optimised-linear" } else { "" };
    let paper = info.paper.map(|p| format!(" After {}: {}. {}.", p.authors, p.title, p.venue));
    let doc = format!(
        "Codec `{}`: {}. Sites: {}{filter}.{}",
        info.id,
        info.summary,
        sites.join(", "),
        paper.unwrap_or_default()
    );
    Table::new(doc, keys)
}

/// The default of a setting as TOML. Words are quoted.
pub(super) fn written(kind: SettingKind, default: &str) -> String {
    match kind {
        SettingKind::Choice(_) | SettingKind::Text { .. } => format!("\"{default}\""),
        SettingKind::Block { .. } if default.contains('x') => format!("\"{default}\""),
        _ => default.to_owned(),
    }
}
