//! `clip_box`

use crate::diagnostic::Diagnostic;
use crate::pipeline::document::Node;
use crate::render::ClipBox;

/// `None` is the whole volume, however that was written.
pub(super) fn read(node: &Node) -> Result<Option<ClipBox>, Diagnostic> {
    let [low, high] = node.array::<2>("two corners, [[x, y, z], [x, y, z]]")?;
    let clip = ClipBox { low: corner(low)?, high: corner(high)? };
    let Some(axis) = clip.empty_axis() else { return Ok((clip != ClipBox::WHOLE).then_some(clip)) };
    let coordinate = |corner: &Node| corner.list("a corner").map(|items| items[axis].place.clone());
    let message = format!("the clip box is empty along {}", ["x", "y", "z"][axis]);
    Err(Diagnostic::new(message, coordinate(high)?, "not above the lower corner")
        .with_secondary(coordinate(low)?, "the lower corner")
        .with_note("write the lower corner first; the whole volume is [[0, 0, 0], [1, 1, 1]]"))
}

fn corner(node: &Node) -> Result<[f32; 3], Diagnostic> {
    let mut corner = [0.0; 3];
    for (share, item) in corner.iter_mut().zip(node.array::<3>("a corner, [x, y, z]")?) {
        *share = item
            .number("a share of the volume's extent from 0 to 1", |x| (0.0..=1.0).contains(&x))
            .map_err(|e| e.with_note("0 is the volume's lower face, 1 its upper one"))?
            as f32;
    }
    Ok(corner)
}
