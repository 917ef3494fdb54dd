//! The search for a transfer function's segment, unrolled.

use std::fmt::Write as _;

use cvr_shaders as shaders;

use super::text::Text;
use crate::render::SegmentSearch;

/// What the search reads, as a declaration without its binding; `None` where it reads nothing of its own.
pub fn declaration(search: SegmentSearch) -> Option<String> {
    match search {
        SegmentSearch::Every { fours } => {
            Some(format!("var<uniform> transfer_keys: array<vec4<f32>, {fours}>;"))
        }
        SegmentSearch::Guide => Some("var<uniform> transfer_guide: vec4<f32>;".to_owned()),
        SegmentSearch::Tree { .. } => None,
    }
}

/// Appends `transfer_segment`.
pub fn write(out: &mut Text, search: SegmentSearch) {
    let text = match search {
        SegmentSearch::Guide => return out.template(shaders::SEGMENT_GUIDE),
        SegmentSearch::Every { fours } => every(fours),
        SegmentSearch::Tree { levels } => tree(levels),
    };
    out.template(shaders::KEYS_PASSED);
    out.generated("segments of the transfer function", &text);
}

fn every(fours: u32) -> String {
    let passed = (0..fours).map(|i| format!("keys_passed(value, transfer_keys[{i}])"));
    let sum = passed.collect::<Vec<_>>().join(" + ");
    format!("fn transfer_segment(value: f32) -> u32 {{\n    return {sum};\n}}\n")
}

/// Nodes lie level by level. Five follow on each, and what follows the last level are the segments.
fn tree(levels: u32) -> String {
    let mut text = "fn transfer_segment(value: f32) -> u32 {\n".to_owned();
    let _ = writeln!(text, "    var at = keys_passed(value, transfer_texel(0u, 0u));");
    for level in 1..levels {
        let first = (5_usize.pow(level) - 1) / 4;
        let _ = writeln!(text, "    at = 5u * at + keys_passed(value, transfer_texel({first}u + at, 0u));");
    }
    let end = SegmentSearch::TREE_END;
    let found = if 5_usize.pow(levels) > end + 1 { format!("min(at, {end}u)") } else { "at".to_owned() };
    let _ = writeln!(text, "    return {found};\n}}");
    text
}
