//! The table of keys as Markdown.

use std::fmt::Write as _;

use crate::pipeline::keys::shape::{Bounds, Key, Presence, Shape, Table};

const INTRODUCTION: &str = "\
# Configurations

An experiment is a TOML file. This page lists every key. Any other key is refused, with a caret under it and the nearest
key that exists. `cvr check-config FILE` reports what is wrong with a file. `cvr explain FILE` estimates what it would run, and
its time and memory. `--set scene.step_voxels=1.0` overrides any key. The files in `configs/` run as they are.

`cvr schema --markdown` prints this page. It uses the same table as [experiment.schema.json](../experiment.schema.json).
Editors check and complete configurations with that schema: Even Better TOML (VS Code), or any other editor that runs the
language server taplo, needs only the first line

```toml
#:schema ../docs/experiment.schema.json
```

(a path relative to the file, or a URL). A schema cannot express everything that the program checks. Only
`cvr check-config` reports names that are missing or repeated, control points in the wrong order, empty boxes and
directions, blocks that are too large, and what a codec refuses itself. The value `1.0` counts as an integer in the
schema, but not in the program.

In the column *value*, *one or a list* marks an axis. Each member of a list is tried; equal settings of a codec or
renderer are tried once. Axes multiply. A product of more cells than `max_cells` is refused before it is made.
";

const EXAMPLE: &str = include_str!("../../../../docs/example.toml");

/// The page.
pub(super) fn document(configuration: &Table) -> String {
    let mut page = format!("{INTRODUCTION}\n## Example\n\n```toml\n{}\n```\n", EXAMPLE.trim_end());
    for key in &configuration.keys {
        section(&mut page, key);
    }
    page
}

/// A table of the file. Writing to a string cannot fail.
fn section(page: &mut String, key: &Key) {
    match &key.shape {
        Shape::Table(table) => write_table(page, 2, &format!("[{}]", key.name), table),
        Shape::Tables(kinds) => {
            let _ = write!(page, "\n## `[[{}]]`\n\n{}.\n", key.name, key.doc);
            for (kind, table) in kinds {
                let title = match &kinds[..] {
                    [_] => {
                        write_keys(page, 2, &key.name, table);
                        continue;
                    }
                    _ if key.name == "codec" => format!("id = \"{kind}\""),
                    _ => format!("{kind} = …"),
                };
                write_table(page, 3, &title, table);
            }
        }
        _ => {}
    }
}

fn write_table(page: &mut String, level: usize, title: &str, table: &Table) {
    let _ = write!(page, "\n{} `{title}`\n", "#".repeat(level));
    write_keys(page, level, title.trim_matches(['[', ']']), table);
}

fn write_keys(page: &mut String, level: usize, title: &str, table: &Table) {
    let _ = write!(page, "\n{}\n\n| key | value | default | |\n|---|---|---|---|\n", table.doc);
    for key in &table.keys {
        let default = match &key.presence {
            Presence::Required => "required".to_owned(),
            Presence::Default(value) => format!("`{value}`"),
            Presence::Absent(meaning) => (*meaning).to_owned(),
        };
        let unit = if key.unit.is_empty() { String::new() } else { format!(", {}", key.unit) };
        let mut doc = cell(&key.doc);
        let meanings = key.shape.words().iter().filter(|(_, doc)| !doc.is_empty());
        for (i, (word, meaning)) in meanings.enumerate() {
            let _ = write!(doc, "{}`{word}`: {}", if i == 0 { ". " } else { "; " }, cell(meaning));
        }
        let value = cell(&format!("{}{unit}", value(&key.shape)));
        let _ = writeln!(page, "| `{}` | {value} | {} | {doc} |", key.name, cell(&default));
    }
    for (key, table) in table.keys.iter().filter_map(|key| Some((key, inner(&key.shape)?))) {
        write_table(page, level + 1, &format!("{title}.{}", key.name), table);
    }
}

/// The table that a key may hold.
fn inner(shape: &Shape) -> Option<&Table> {
    match shape {
        Shape::Table(table) => Some(table),
        Shape::Any(shapes) => shapes.iter().find_map(inner),
        _ => None,
    }
}

/// Escapes text so that it does not end a cell of the table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

/// The allowed values, in words.
fn value(shape: &Shape) -> String {
    match shape {
        Shape::Name => "a name".to_owned(),
        Shape::Path => "a path".to_owned(),
        Shape::Text => "a name of a volume".to_owned(),
        Shape::Boolean => "`true` or `false`".to_owned(),
        Shape::Integer { min, max: i64::MAX } => format!("an integer from {min}"),
        Shape::Integer { min, max } => format!("an integer from {min} to {max}"),
        Shape::Number(bounds) => format!("a number{}", limits(*bounds)),
        Shape::Words(words) => {
            let words: Vec<String> = words.iter().map(|(word, _)| format!("`\"{word}\"`")).collect();
            words.join(", ")
        }
        Shape::Colour { opacity: false } => "`\"#rrggbb\"`".to_owned(),
        Shape::Colour { opacity: true } => "`\"#rrggbb\"` or `\"#rrggbbaa\"`".to_owned(),
        Shape::Setting(kind) => kind.describe(),
        Shape::Tuple(items) => tuple(items),
        Shape::List { item, least, most: None } => format!("a list of at least {least} × {}", value(item)),
        Shape::List { item, least, most: Some(most) } => {
            format!("a list of {least} to {most} × {}", value(item))
        }
        Shape::Axis(item) => format!("one or a list, none twice: {}", value(item)),
        Shape::Sweep(item) => format!("one or a list: {}", value(item)),
        Shape::Any(shapes) => shapes.iter().map(value).collect::<Vec<_>>().join("; or "),
        Shape::Table(_) => "a table, see below".to_owned(),
        Shape::Tables(_) => "tables".to_owned(),
    }
}

fn tuple(items: &[Shape]) -> String {
    let items: Vec<String> = items.iter().map(value).collect();
    match &items[..] {
        [first, rest @ ..] if !rest.is_empty() && rest.iter().all(|item| item == first) => {
            format!("a list of {} × {first}", items.len())
        }
        _ => format!("[{}]", items.join(", ")),
    }
}

fn limits(bounds: Bounds) -> String {
    let mut limits = Vec::new();
    // Bounds at the ends of single precision are not shown.
    let is_met = |limit: &f64| limit.abs() < 1e30;
    limits.extend(bounds.min.filter(is_met).map(|min| format!("from {min}")));
    limits.extend(bounds.above.map(|above| format!("above {above}")));
    limits.extend(bounds.max.filter(is_met).map(|max| format!("to {max}")));
    limits.extend(bounds.below.map(|below| format!("below {below}")));
    if limits.is_empty() { String::new() } else { format!(" {}", limits.join(" ")) }
}
