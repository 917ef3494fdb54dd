//! `--set key=value`: changing a document before it is read.

use super::document::{Document, Entry, Node, Value};
use super::keys;
use super::suggest::ways_out;
use crate::diagnostic::{Diagnostic, Place, SourceText};

/// One part of a dotted path.
struct Segment {
    name: String,
    place: Place,
}

impl Document {
    /// Applies one override, `path=value`, as `--set` takes it.
    ///
    /// The path is dotted: `experiment.seed`, `pipeline.filter`. In a list of tables, the second part selects tables by
    /// name (`volume.bonsai.file`, `scene.front.camera.zoom`) or id (`codec.s3dc.block`). Without it, all tables of the
    /// list change (`scene.step_voxels`). The value is TOML. Text that is not TOML counts as a string, so
    /// `pipeline.filter=linear` needs no quotes. Unknown keys and wrong values are found when the document is read. The
    /// error then points at the override.
    ///
    /// # Errors
    /// When the text is no assignment, the path names a table that does not exist, or runs through a value that
    /// is no table.
    pub fn set(&mut self, assignment: &str) -> Result<(), Diagnostic> {
        let source = SourceText::new("--set", assignment);
        let whole = Place::new(source.clone(), 0..assignment.len());
        let Some(equals) = split_at_equals(assignment) else {
            return Err(Diagnostic::new("an override needs a key and a value", whole, "no `=`")
                .with_note("write, for instance, `--set scene.step_voxels=1.0`"));
        };
        let path = parse_path(&whole, &assignment[..equals])?;
        let text = &assignment[equals + 1..];
        let offset = equals + 1 + (text.len() - text.trim_start().len());
        let text = text.trim();
        let value = match Node::parse(text, &source, offset) {
            Ok(node) => node,
            // The value looks like TOML but is wrong. It must not become a string.
            Err(error) if text.starts_with(['[', '{', '"', '\'']) => return Err(error),
            Err(_) => {
                let place = Place::new(source, offset..offset + text.len());
                Node { place, value: Value::Text(text.to_owned()) }
            }
        };
        assign(&mut self.root, &path, &value)
    }
}

/// The first `=` outside quotes.
fn split_at_equals(text: &str) -> Option<usize> {
    let mut quote = None;
    for (i, c) in text.char_indices() {
        match (quote, c) {
            (None, '=') => return Some(i),
            (None, '"' | '\'') => quote = Some(c),
            (Some(q), c) if q == c => quote = None,
            _ => {}
        }
    }
    None
}

/// Reads a dotted key by TOML's own rules for keys.
fn parse_path(whole: &Place, key: &str) -> Result<Vec<Segment>, Diagnostic> {
    let place = Place::new(whole.source.clone(), 0..key.len());
    let bad = || {
        Diagnostic::new("an override begins with a dotted key", place.clone(), "this is none")
            .with_note("write, for instance, `--set scene.step_voxels=1.0`")
    };
    let document = Document::parse("", &format!("{key}=0")).map_err(|_| bad())?;
    let mut path = Vec::new();
    let mut node = document.root;
    loop {
        match node.value {
            Value::Table(mut entries) if entries.len() == 1 => {
                let entry = entries.remove(0);
                let span = entry.place.span;
                path.push(Segment { name: entry.key, place: Place::new(whole.source.clone(), span) });
                node = entry.node;
            }
            Value::Integer(_) => return Ok(path),
            _ => return Err(bad()),
        }
    }
}

/// For a list of tables: the key that names a table, and the keys of each table.
fn list_of_tables(name: &str) -> Option<(&'static str, Vec<String>)> {
    match name {
        "volume" => Some(("name", keys::volume::names())),
        "scene" => Some(("name", keys::scene::table().keys.into_iter().map(|key| key.name).collect())),
        "codec" => Some(("id", Vec::new())),
        _ => None,
    }
}

fn assign(root: &mut Node, path: &[Segment], value: &Node) -> Result<(), Diagnostic> {
    let [section, rest @ ..] = path else { return Ok(()) };
    let Some((naming, keys)) = list_of_tables(&section.name) else { return put(root, path, value) };
    let Value::Table(entries) = &mut root.value else { return Ok(()) };
    let entry = entries.iter_mut().find(|e| e.key == section.name);
    let tables = match entry.map(|e| &mut e.node.value) {
        Some(Value::List(tables)) => tables,
        _ => {
            let message = format!("the configuration has no `[[{}]]`", section.name);
            return Err(Diagnostic::new(message, section.place.clone(), "nothing to change"));
        }
    };
    let [first, inner @ ..] = rest else {
        let message = format!("`{}` is a list of tables: which key of theirs is meant?", section.name);
        return Err(Diagnostic::new(message, section.place.clone(), "no key follows")
            .with_note(format!("write `{0}.KEY=VALUE`, or `{0}.NAME.KEY=VALUE`", section.name)));
    };
    let names: Vec<String> = tables.iter().filter_map(|table| name_of(table, naming)).collect();
    let mut chosen: Vec<&mut Node> = tables.iter_mut().collect();
    let mut path = rest;
    if !inner.is_empty() && names.contains(&first.name) {
        chosen.retain(|table| name_of(table, naming).as_ref() == Some(&first.name));
        path = inner;
    } else if !inner.is_empty() && !keys.contains(&first.name) {
        let message = format!("no {} is called `{}`", section.name, first.name);
        let mut error = Diagnostic::new(message, first.place.clone(), format!("unknown {}", section.name));
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        error.notes = ways_out(&first.name, &format!("{}s", section.name), &known);
        return Err(error);
    }
    chosen.into_iter().try_for_each(|table| put(table, path, value))
}

fn name_of(table: &Node, key: &str) -> Option<String> {
    let Value::Table(entries) = &table.value else { return None };
    let name = entries.iter().find(|e| e.key == key)?;
    name.node.text().ok().map(str::to_owned)
}

/// Puts a value into a table. Creates missing tables on the path. A replaced value keeps its position in the order of
/// keys.
fn put(node: &mut Node, path: &[Segment], value: &Node) -> Result<(), Diagnostic> {
    let [segment, rest @ ..] = path else {
        *node = value.clone();
        return Ok(());
    };
    let kind = node.kind();
    let Value::Table(entries) = &mut node.value else {
        let message = format!("`{}` cannot be set: what holds it is {kind}, not a table", segment.name);
        let error = Diagnostic::new(message, segment.place.clone(), "no such key");
        return Err(error.with_secondary(node.place.clone(), format!("{kind} stands here")));
    };
    let at = entries.iter().position(|e| e.key == segment.name).unwrap_or_else(|| {
        let node = Node { place: segment.place.clone(), value: Value::Table(Vec::new()) };
        entries.push(Entry { key: segment.name.clone(), place: segment.place.clone(), node });
        entries.len() - 1
    });
    let entry = &mut entries[at];
    if rest.is_empty() {
        entry.place = segment.place.clone();
    }
    put(&mut entry.node, rest, value)
}
