//! `[[codec]]`: free-form, held to the schema that the codec brings.

use super::super::config::{CodecSweep, Sweep};
use super::super::document::{Entry, Node, Value};
use super::super::read::{Fields, unknown};
use super::super::suggest::ways_out;
use super::Known;
use crate::codec::{CodecInfo, Setting, SettingValue};
use crate::diagnostic::Diagnostic;

pub(super) fn read(node: &Node, known: &Known<'_>) -> Result<CodecSweep, Diagnostic> {
    let fields = Fields::open("the codec", node)?;
    let id_node = fields.require("id", "id = \"raw\"")?;
    let id = id_node.text()?;
    let ids: Vec<&str> = known.codecs.iter().map(|c| c.info().id).collect();
    let Ok(codec) = known.codecs.get(id) else {
        return Err(unknown(&id_node.place, "codec", id, &ids));
    };
    let settings = fields.entries().iter().filter(|entry| entry.key != "id");
    let sweeps = settings.map(|entry| sweep(entry, codec.info())).collect::<Result<_, _>>()?;
    Ok(CodecSweep { id: id.to_owned(), sweeps })
}

/// One value, or a list of values to try.
fn sweep(entry: &Entry, info: &CodecInfo) -> Result<Sweep, Diagnostic> {
    let Some(setting) = info.setting(&entry.key) else { return Err(unknown_setting(entry, info)) };
    let nodes = match &entry.node.value {
        Value::List(items) if items.is_empty() => {
            let message = format!("`{}` lists no value to try", entry.key);
            return Err(entry
                .node
                .error(message, "empty list")
                .with_note(format!("leave the line away for the default, {}", setting.default)));
        }
        Value::List(items) => items.as_slice(),
        _ => std::slice::from_ref(&entry.node),
    };
    let values = nodes.iter().map(|node| value(node, setting, info)).collect::<Result<_, _>>()?;
    Ok(Sweep { name: entry.key.clone(), values })
}

fn value(node: &Node, setting: &Setting, info: &CodecInfo) -> Result<SettingValue, Diagnostic> {
    let written = match &node.value {
        Value::Boolean(b) => Some(SettingValue::Boolean(*b)),
        Value::Integer(i) => Some(SettingValue::Integer(*i)),
        Value::Float(x) => Some(SettingValue::Float(*x)),
        Value::Text(text) => Some(SettingValue::Text(text.clone())),
        Value::DateTime | Value::List(_) | Value::Table(_) => None,
    };
    written.and_then(|value| setting.kind.canonical(&value)).ok_or_else(|| {
        let expected = setting.kind.describe();
        let message = format!("`{}` of codec `{}` cannot be `{}`", setting.name, info.id, node.place.text());
        node.error(message, format!("expected {expected}"))
            .with_note(format!("{}: {}", setting.name, setting.doc))
            .with_note("a list is a sweep: each of its values is tried")
    })
}

fn unknown_setting(entry: &Entry, info: &CodecInfo) -> Diagnostic {
    let message = format!("codec `{}` has no setting `{}`", info.id, entry.key);
    let mut error = Diagnostic::new(message, entry.place.clone(), "unknown setting");
    let names: Vec<&str> = info.settings.iter().map(|s| s.name).collect();
    error.notes = ways_out(&entry.key, "settings", &names);
    error
}
