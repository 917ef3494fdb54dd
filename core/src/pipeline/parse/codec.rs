//! `[[codec]]`: its other keys are checked against the codec's schema.

use super::super::config::CodecSweep;
use super::super::document::{Entry, Node};
use super::super::read::{Fields, unknown};
use super::super::suggest::ways_out;
use super::{Known, settings};
use crate::codec::CodecInfo;
use crate::diagnostic::Diagnostic;

pub(super) fn read(
    node: &Node,
    known: &Known<'_>,
    notes: &mut Vec<String>,
) -> Result<CodecSweep, Diagnostic> {
    let fields = Fields::open("the codec", node)?;
    let id_node = fields.require("id", "id = \"raw\"")?;
    let id = id_node.text()?;
    let ids: Vec<&str> = known.codecs.iter().map(|c| c.info().id).collect();
    let Ok(codec) = known.codecs.get(id) else {
        return Err(unknown(&id_node.place, "codec", id, &ids));
    };
    let (info, owner) = (codec.info(), format!("codec `{id}`"));
    let written = fields.entries().iter().filter(|entry| entry.key != "id");
    let mut sweep = |entry: &Entry| match info.setting(&entry.key) {
        Some(setting) => settings::sweep(entry, setting, &owner, notes),
        None => Err(unknown_setting(entry, info)),
    };
    let sweeps = written.map(&mut sweep).collect::<Result<_, _>>()?;
    Ok(CodecSweep { id: id.to_owned(), sweeps })
}

fn unknown_setting(entry: &Entry, info: &CodecInfo) -> Diagnostic {
    let message = format!("codec `{}` has no setting `{}`", info.id, entry.key);
    let mut error = Diagnostic::new(message, entry.place.clone(), "unknown setting");
    let names: Vec<&str> = info.settings.iter().map(|s| s.name).collect();
    error.notes = ways_out(&entry.key, "settings", &names);
    error
}
