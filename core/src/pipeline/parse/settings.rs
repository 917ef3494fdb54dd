//! Settings of codecs and renderers, checked against their schemas.

use std::collections::HashSet;

use super::super::config::Sweep;
use super::super::document::{Entry, Node, Value};
use crate::codec::{Setting, SettingValue};
use crate::diagnostic::Diagnostic;

/// Reads one value of a setting, or a list of values to try. Errors name the `owner` ("codec `s3dc`"). Equal values
/// count once, with a note.
pub(super) fn sweep(
    entry: &Entry,
    setting: &Setting,
    owner: &str,
    notes: &mut Vec<String>,
) -> Result<Sweep, Diagnostic> {
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
    let mut values = Vec::new();
    let mut seen = HashSet::new();
    let mut again: Vec<String> = Vec::new();
    for node in nodes {
        let value = value(node, setting, owner)?;
        // Canonical values of one setting are equal if their texts are.
        if seen.insert(value.to_string()) {
            values.push(value);
        } else {
            again.push(value.to_string());
        }
    }
    if let Some(first) = again.first() {
        let (place, others) = (entry.place.line(), again.len() - 1);
        let others = if others == 0 { String::new() } else { format!(" and {others} more") };
        notes.push(format!(
            "{place}: `{}` of {owner} lists `{first}`{others} again; equal values count once",
            entry.key
        ));
    }
    Ok(Sweep { name: entry.key.clone(), values })
}

fn value(node: &Node, setting: &Setting, owner: &str) -> Result<SettingValue, Diagnostic> {
    let written = match &node.value {
        Value::Boolean(b) => Some(SettingValue::Boolean(*b)),
        Value::Integer(i) => Some(SettingValue::Integer(*i)),
        Value::Float(x) => Some(SettingValue::Float(*x)),
        Value::Text(text) => Some(SettingValue::Text(text.clone())),
        Value::DateTime | Value::List(_) | Value::Table(_) => None,
    };
    written.and_then(|value| setting.kind.canonical(&value)).ok_or_else(|| {
        let expected = setting.kind.describe();
        let message = format!("`{}` of {owner} cannot be `{}`", setting.name, node.place.text());
        node.error(message, format!("expected {expected}"))
            .with_note(format!("{}: {}", setting.name, setting.doc))
            .with_note("a list is a sweep: each of its values is tried")
    })
}
