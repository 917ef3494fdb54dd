//! `opacity`

use crate::diagnostic::Diagnostic;
use crate::pipeline::document::{Node, Value};
use crate::pipeline::keys;
use crate::pipeline::parse::path;
use crate::pipeline::read::Fields;
use crate::pipeline::scene::SceneOpacity;
use crate::render::ColourOpacity;

/// A word, or a table in a file.
pub(super) fn read(node: &Node) -> Result<SceneOpacity, Diagnostic> {
    match node.value {
        Value::Text(_) => {
            let known = ColourOpacity::NAMED.map(|(name, _, opacity)| (name, opacity));
            let word = node.one_of("channel", &known);
            word.map(SceneOpacity::Known)
                .map_err(|e| e.with_note("a table over all colours is { table = \"file.npy\" }"))
        }
        Value::Table(_) => {
            let fields = Fields::of("the opacity", node, &keys::scene::opacity_table().names())?;
            path(fields.require("table", "table = \"file.npy\"")?).map(SceneOpacity::File)
        }
        _ => Err(node.wrong_type("\"luminance\", a channel, or { table = \"file.npy\" }")),
    }
}
