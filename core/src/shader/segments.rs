//! The search for a transfer function's segment, unrolled.

use std::fmt::Write as _;

use cvr_shaders as shaders;

use super::Module;
use crate::render::SegmentSearch;

/// The module that declares `transfer_segment`.
#[must_use]
pub fn transfer_segments(search: SegmentSearch) -> Module {
    let generated = |source| Module::Generated { purpose: "segments of the transfer function", source };
    match search {
        SegmentSearch::Guide { wide: false } => shaders::SEGMENT_GUIDE.into(),
        SegmentSearch::Guide { wide: true } => shaders::SEGMENT_WIDE_GUIDE.into(),
        SegmentSearch::Every { points } => generated(every(points)),
        SegmentSearch::Tree { levels } => generated(tree(levels)),
    }
}

/// Point after point.
fn every(points: u32) -> String {
    let key =
        |i: u32| format!("inputs.view.transfer_keys[{}].{}", i / 4, ["x", "y", "z", "w"][i as usize % 4]);
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

/// Nodes are stored level by level. Each has five children. The children of the last level are the segments.
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
