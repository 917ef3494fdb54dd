//! A TOML document that knows where each value was written.

use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::diagnostic::{Diagnostic, Place, SourceText};

/// A parsed TOML file with overrides applied. Its keys are not checked yet.
///
/// Every value has its own source. So an error in an override points at the override, not at the line that it replaced.
#[derive(Clone, Debug)]
pub struct Document {
    pub(super) root: Node,
}

/// A value and the place where it was written.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub place: Place,
    pub value: Value,
}

#[derive(Clone, Debug)]
pub(super) enum Value {
    Boolean(bool),
    Integer(i64),
    Float(f64),
    Text(String),
    DateTime,
    List(Vec<Node>),
    /// In the order in which the keys were written.
    Table(Vec<Entry>),
}

#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub key: String,
    pub place: Place,
    pub node: Node,
}

impl Document {
    /// Parses a file. Errors show `name`.
    ///
    /// # Errors
    /// When the text is no TOML.
    pub fn parse(name: &str, text: &str) -> Result<Self, Diagnostic> {
        let source = SourceText::new(name, text);
        let table = DeTable::parse(text).map_err(|e| syntax_error(&e, &source, 0))?;
        let whole = table.span();
        let root = convert_table(table.into_inner(), &source, 0)?;
        Ok(Self { root: Node { place: Place::new(source, whole), value: root } })
    }
}

impl Node {
    /// Parses a value as it would stand after `=`. It begins at byte `offset` of `source`.
    pub fn parse(text: &str, source: &Arc<SourceText>, offset: usize) -> Result<Self, Diagnostic> {
        let value = DeValue::parse(text).map_err(|e| syntax_error(&e, source, offset))?;
        convert(value, source, offset)
    }

    /// The type of the value, with its article.
    pub fn kind(&self) -> &'static str {
        match self.value {
            Value::Boolean(_) => "a boolean",
            Value::Integer(_) => "an integer",
            Value::Float(_) => "a float",
            Value::Text(_) => "a string",
            Value::DateTime => "a date",
            Value::List(_) => "a list",
            Value::Table(_) => "a table",
        }
    }
}

fn syntax_error(error: &toml::de::Error, source: &Arc<SourceText>, offset: usize) -> Diagnostic {
    let span = error.span().unwrap_or(0..0);
    let place = Place::new(source.clone(), span.start + offset..span.end + offset);
    Diagnostic::new(format!("this is no TOML: {}", error.message()), place, "")
}

fn convert(value: Spanned<DeValue<'_>>, source: &Arc<SourceText>, offset: usize) -> Result<Node, Diagnostic> {
    let span = value.span();
    let place = Place::new(source.clone(), span.start + offset..span.end + offset);
    let number = |number: Option<Value>| {
        number.ok_or_else(|| Diagnostic::new("the number is too large", place.clone(), "exceeds 64 bits"))
    };
    let value = match value.into_inner() {
        DeValue::Boolean(b) => Value::Boolean(b),
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Datetime(_) => Value::DateTime,
        DeValue::Integer(i) => number(i64::from_str_radix(i.as_str(), i.radix()).ok().map(Value::Integer))?,
        DeValue::Float(x) => number(x.as_str().parse().ok().map(Value::Float))?,
        DeValue::Array(items) => {
            let nodes = items.into_iter().map(|item| convert(item, source, offset));
            Value::List(nodes.collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => convert_table(table, source, offset)?,
    };
    Ok(Node { place, value })
}

fn convert_table(table: DeTable<'_>, source: &Arc<SourceText>, offset: usize) -> Result<Value, Diagnostic> {
    let mut entries = Vec::new();
    for (key, value) in table {
        let span = key.span();
        let place = Place::new(source.clone(), span.start + offset..span.end + offset);
        let node = convert(value, source, offset)?;
        entries.push(Entry { key: key.into_inner().into_owned(), place, node });
    }
    // `toml` sorts keys by name. Sweeps run in the order of the file.
    entries.sort_by_key(|entry| entry.place.span.start);
    Ok(Value::Table(entries))
}
