//! Reads typed values from a document. Each error has a caret under the wrong text.

use super::document::{Entry, Node, Value};
use super::keys::number::NumberKey;
use super::suggest::ways_out;
use crate::diagnostic::{Diagnostic, Place};

impl Node {
    /// An error at this value.
    pub fn error(&self, message: impl Into<String>, label: impl Into<String>) -> Diagnostic {
        Diagnostic::new(message, self.place.clone(), label)
    }

    /// The value is of the wrong type.
    pub fn wrong_type(&self, expected: &str) -> Diagnostic {
        self.error(format!("expected {expected}, found {}", self.kind()), format!("expected {expected}"))
    }

    /// The value has the right type but is not allowed.
    pub fn not_allowed(&self, expected: &str) -> Diagnostic {
        self.error(
            format!("expected {expected}, found `{}`", self.place.text()),
            format!("expected {expected}"),
        )
    }

    pub fn text(&self) -> Result<&str, Diagnostic> {
        match &self.value {
            Value::Text(text) => Ok(text),
            _ => Err(self.wrong_type("a string")),
        }
    }

    pub fn boolean(&self) -> Result<bool, Diagnostic> {
        match self.value {
            Value::Boolean(b) => Ok(b),
            _ => Err(self.wrong_type("true or false")),
        }
    }

    pub fn list(&self, expected: &str) -> Result<&[Self], Diagnostic> {
        match &self.value {
            Value::List(items) => Ok(items),
            _ => Err(self.wrong_type(expected)),
        }
    }

    /// A list of exactly `N` values.
    pub fn array<const N: usize>(&self, expected: &str) -> Result<&[Self; N], Diagnostic> {
        let items = self.list(expected)?;
        items.try_into().map_err(|_| {
            self.error(
                format!("expected {expected}, found a list of {}", items.len()),
                format!("expected {expected}"),
            )
        })
    }

    /// An integer within bounds. `expected` states them in words.
    pub fn integer(&self, min: i64, max: i64, expected: &str) -> Result<i64, Diagnostic> {
        match self.value {
            Value::Integer(i) if (min..=max).contains(&i) => Ok(i),
            Value::Integer(_) => Err(self.not_allowed(expected)),
            _ => Err(self.wrong_type(expected)),
        }
    }

    /// A finite number that `allowed` accepts; an integer counts as a number.
    pub fn number(&self, expected: &str, allowed: impl Fn(f64) -> bool) -> Result<f64, Diagnostic> {
        let number = match self.value {
            Value::Integer(i) => i as f64,
            Value::Float(x) => x,
            _ => return Err(self.wrong_type(expected)),
        };
        if number.is_finite() && allowed(number) { Ok(number) } else { Err(self.not_allowed(expected)) }
    }

    /// One value, or a list of values without repetition. `item` reads each.
    pub fn one_or_many<T: PartialEq>(
        &self,
        what: &str,
        item: impl Fn(&Self) -> Result<T, Diagnostic>,
    ) -> Result<Vec<T>, Diagnostic> {
        let Value::List(nodes) = &self.value else { return Ok(vec![item(self)?]) };
        if nodes.is_empty() {
            let error = self.error(format!("the list names no {what}"), "empty list");
            return Err(error.with_note(format!("name at least one {what}")));
        }
        let mut items: Vec<T> = Vec::new();
        for node in nodes {
            let value = item(node)?;
            if let Some(first) = items.iter().position(|i| *i == value) {
                let message =
                    format!("{what} `{}` is listed twice", node.text().unwrap_or(node.place.text()));
                return Err(node
                    .error(message, "again")
                    .with_secondary(nodes[first].place.clone(), "first")
                    .with_note("each would be drawn once: remove one of the two"));
            }
            items.push(value);
        }
        Ok(items)
    }

    /// A word from a list, as the value that it names.
    pub fn one_of<T>(&self, what: &str, known: &[(&str, T)]) -> Result<T, Diagnostic>
    where
        T: Clone,
    {
        let word = self.text()?;
        let found = known.iter().find(|(name, _)| *name == word).map(|(_, thing)| thing.clone());
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        found.ok_or_else(|| unknown(&self.place, what, word, &names))
    }
}

/// An unknown word, with the known ones.
pub(super) fn unknown(place: &Place, what: &str, word: &str, known: &[&str]) -> Diagnostic {
    let mut error =
        Diagnostic::new(format!("no {what} is called `{word}`"), place.clone(), format!("unknown {what}"));
    error.notes = ways_out(word, &format!("{what}s"), known);
    error
}

/// The keys of one table.
#[derive(Copy, Clone, Debug)]
pub(super) struct Fields<'a> {
    /// Name of the table in messages: "the experiment", "scene `front`".
    what: &'a str,
    node: &'a Node,
    entries: &'a [Entry],
}

impl<'a> Fields<'a> {
    /// Opens a table; its keys may be checked later with [`Fields::allow`].
    pub fn open(what: &'a str, node: &'a Node) -> Result<Self, Diagnostic> {
        match &node.value {
            Value::Table(entries) => Ok(Self { what, node, entries }),
            _ => Err(node.wrong_type(&format!("a table that describes {what}"))),
        }
    }

    /// Opens a table that has no keys but these.
    pub fn of(what: &'a str, node: &'a Node, known: &[&str]) -> Result<Self, Diagnostic> {
        let fields = Self::open(what, node)?;
        fields.allow(known)?;
        Ok(fields)
    }

    /// Refuses the first key that is not among `known`.
    pub fn allow(&self, known: &[&str]) -> Result<(), Diagnostic> {
        match self.entries.iter().find(|e| !known.contains(&e.key.as_str())) {
            Some(entry) => Err(self.unknown_key(entry, known)),
            None => Ok(()),
        }
    }

    /// The error for a key that this table does not have.
    pub fn unknown_key(&self, entry: &Entry, known: &[&str]) -> Diagnostic {
        let message = format!("{} has no key `{}`", self.what, entry.key);
        let mut error = Diagnostic::new(message, entry.place.clone(), "unknown key");
        error.notes = ways_out(&entry.key, "keys", known);
        error
    }

    /// An error about the table as a whole.
    pub fn error(&self, message: impl Into<String>, label: impl Into<String>) -> Diagnostic {
        self.node.error(message, label)
    }

    pub fn entries(&self) -> &'a [Entry] {
        self.entries
    }

    pub fn entry(&self, key: &str) -> Option<&'a Entry> {
        self.entries.iter().find(|e| e.key == key)
    }

    pub fn get(&self, key: &str) -> Option<&'a Node> {
        self.entry(key).map(|e| &e.node)
    }

    /// A required key. `example` is a line that would work.
    pub fn require(&self, key: &str, example: &str) -> Result<&'a Node, Diagnostic> {
        self.get(key).ok_or_else(|| {
            Diagnostic::new(format!("{} has no `{key}`", self.what), self.node.place.clone(), "missing here")
                .with_note(format!("write, for instance, `{example}`"))
        })
    }

    /// Reads a key if it is there.
    pub fn optional<T>(
        &self,
        key: &str,
        read: impl FnOnce(&'a Node) -> Result<T, Diagnostic>,
    ) -> Result<Option<T>, Diagnostic> {
        self.get(key).map(read).transpose()
    }

    /// A number within the bounds of its key, or the key's default.
    pub fn number(&self, key: &NumberKey) -> Result<f64, Diagnostic> {
        let number = self.optional(key.name, |node| node.number(key.expected, |x| key.allows(x)))?;
        Ok(number.unwrap_or(key.default()))
    }
}
