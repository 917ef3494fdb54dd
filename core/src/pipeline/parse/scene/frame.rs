//! `frame`

use crate::diagnostic::Diagnostic;
use crate::pipeline::document::{Node, Value};
use crate::pipeline::scene::FrameRange;

/// Reads a frame, or the first and last frame of a range.
pub(super) fn read(node: &Node) -> Result<FrameRange, Diagnostic> {
    let number = |node: &Node| {
        let frame = node.integer(0, i64::from(u32::MAX), "a number of a frame, counted from 0")?;
        Ok::<u32, Diagnostic>(u32::try_from(frame).unwrap_or(u32::MAX))
    };
    if !matches!(node.value, Value::List(_)) {
        let frame = number(node).map_err(|e| e.with_note("a range is written [first, last]"))?;
        return Ok(FrameRange { first: frame, last: frame });
    }
    let [first, last] = node.array::<2>("the first and the last frame")?;
    let range = FrameRange { first: number(first)?, last: number(last)? };
    if range.first > range.last {
        return Err(node.error("a range of frames runs forwards", "the last frame comes before the first"));
    }
    Ok(range)
}
