//! The table of keys (`keys`) as files: [`json_schema`] writes it for editors, [`markdown`] for people.
//!
//! The parser is another thing, since it says with a
//! caret what is wrong; that both know the same keys and refuse the same values is tested wherever the parser is: every
//! text that a test of the parser reads goes through the schema as well.

mod json;
mod markdown;
#[cfg(test)]
pub(super) mod tests;

use super::{Known, keys};

/// The JSON Schema (draft 07) of a configuration, with a line break at its end.
///
/// Draft 07 and not a later one, since the language servers for TOML that are in use complete and explain by its
/// keywords: tuples are `items`, alternatives `oneOf`; `prefixItems` and `if` in place of `oneOf` would leave keys
/// without help.
#[must_use]
pub fn json_schema(known: &Known<'_>) -> String {
    json::document(&keys::configuration(known))
}

/// The same as Markdown: a section for each table, a row for each key.
#[must_use]
pub fn markdown(known: &Known<'_>) -> String {
    markdown::document(&keys::configuration(known))
}
