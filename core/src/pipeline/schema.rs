//! Writes the table of keys (`keys`) as files: [`json_schema`] for editors, [`markdown`] for people.
//!
//! The parser is separate, because its errors have carets. Tests check that both know the same keys and refuse the same
//! values: every text that a test parses is also checked against the schema.

mod json;
mod markdown;
#[cfg(test)]
pub(super) mod tests;

use super::{Known, keys};

/// The JSON Schema (draft 07) of a configuration, with a line break at its end.
///
/// It is draft 07 because the common TOML language servers complete and explain with its keywords: tuples are `items`,
/// alternatives are `oneOf`. With `prefixItems`, or `if` instead of `oneOf`, keys would have no help.
#[must_use]
pub fn json_schema(known: &Known<'_>) -> String {
    json::document(&keys::configuration(known))
}

/// The table as Markdown: a section for each table, a row for each key.
#[must_use]
pub fn markdown(known: &Known<'_>) -> String {
    markdown::document(&keys::configuration(known))
}
