//! The search for a transfer function's segment, unrolled.

use std::fmt::Write as _;

use cvr_shaders as shaders;

use super::text::Text;
use crate::render::SegmentSearch;

/// Appends `transfer_segment`.
pub fn write(out: &mut Text, search: SegmentSearch) {
    match search {
        SegmentSearch::Guide { wide: false } => out.template(shaders::SEGMENT_GUIDE),
        SegmentSearch::Guide { wide: true } => out.template(shaders::SEGMENT_WIDE_GUIDE),
        SegmentSearch::Every { points } => {
            out.generated("segments of the transfer function", &every(points));
        }
        SegmentSearch::Tree { levels } => {
            out.template(shaders::KEYS_PASSED);
            out.generated("segments of the transfer function", &tree(levels));
        }
    }
}

/// Point after point.
fn every(points: u32) -> String {
    let key = |i: u32| format!("view.transfer_keys[{}].{}", i / 4, ["x", "y", "z", "w"][i as usize % 4]);
    let mut text = "fn transfer_segment(value: f32) -> Segment {\n".to_owned();
    let _ = writeln!(text, "    var found = Segment(0u, {0}, {0});\n    var passed: bool;", key(0));
    for i in 0..points {
        let next = key((i + 1).min(points - 1));
        let _ = writeln!(text, "    passed = value >= {};", key(i));
        let _ = writeln!(text, "    found.number = select(found.number, {}u, passed);", i + 1);
        let _ = writeln!(text, "    found.low = select(found.low, {}, passed);", key(i));
        let _ = writeln!(text, "    found.high = select(found.high, {next}, passed);");
    }
    text.push_str("    return found;\n}\n");
    text
}

/// Nodes lie level by level. Five follow on each, and what follows the last level are the segments.
fn tree(levels: u32) -> String {
    let mut text = "fn transfer_segment(value: f32) -> Segment {\n".to_owned();
    let _ = writeln!(text, "    var at = keys_passed(value, transfer_texel(0u, 0u));");
    for level in 1..levels {
        let first = (5_usize.pow(level) - 1) / 4;
        let _ = writeln!(text, "    at = 5u * at + keys_passed(value, transfer_texel({first}u + at, 0u));");
    }
    let end = SegmentSearch::TREE_END;
    if 5_usize.pow(levels) > end + 1 {
        let _ = writeln!(text, "    at = min(at, {end}u);");
    }
    text.push_str("    let ends = transfer_texel(at, 2u);\n    return Segment(at, ends.x, ends.y);\n}\n");
    text
}
