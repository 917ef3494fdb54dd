//! `[[scene]]`

mod camera;
mod clip_box;
mod frame;
mod opacity;
mod shading;
mod transfer_function;

use super::name_of;
use crate::diagnostic::Diagnostic;
use crate::pipeline::colour::parse_colour;
use crate::pipeline::document::{Node, Value};
use crate::pipeline::keys;
use crate::pipeline::keys::number::{EARLY_TERMINATION, STEP_VOXELS};
use crate::pipeline::read::Fields;
use crate::pipeline::scene::Scene;

pub(super) fn read(node: &Node) -> Result<Scene, Diagnostic> {
    let fields = Fields::of("the scene", node, &keys::scene::table().names())?;
    let name = name_of(&fields, "name = \"front\"")?;
    let what = format!("scene `{name}`");
    let fields = Fields::open(&what, node)?;
    let (control_points, domain) = transfer_function::read(&fields)?;
    let step_voxels = fields.number(&STEP_VOXELS)? as f32;
    let never = |e: Diagnostic| e.with_note("1 = every ray runs to its end");
    let early_termination = fields.number(&EARLY_TERMINATION).map_err(never)? as f32;
    if let (Some(node), true) = (fields.get(EARLY_TERMINATION.name), early_termination <= 0.0) {
        return Err(never(node.not_allowed(EARLY_TERMINATION.expected)));
    }
    let volumes =
        fields.optional("volumes", |n| n.one_or_many("volume", |item| item.text().map(str::to_owned)))?;
    Ok(Scene {
        volumes,
        size: fields.optional("size", size)?.unwrap_or(Scene::DEFAULT_SIZE),
        camera: fields.optional("camera", camera::read)?.unwrap_or_default(),
        control_points,
        domain,
        step_voxels,
        early_termination,
        background: fields.optional("background", background)?.unwrap_or_else(Scene::default_background),
        shading: fields.optional("shading", shading::read)?.flatten(),
        clip: fields.optional("clip_box", clip_box::read)?.flatten(),
        opacity: fields.optional("opacity", opacity::read)?.unwrap_or_default(),
        frames: fields.optional("frame", frame::read)?.unwrap_or_default(),
        name,
    })
}

fn size(node: &Node) -> Result<[u32; 2], Diagnostic> {
    let sides = node.array::<2>("width and height in pixels")?;
    let mut size = [0; 2];
    for (side, item) in size.iter_mut().zip(sides) {
        let expected = format!("a number of pixels from 1 to {}", Scene::MAX_SIZE);
        let pixels = item.integer(1, i64::from(Scene::MAX_SIZE), &expected)?;
        *side = u32::try_from(pixels).unwrap_or(Scene::MAX_SIZE);
    }
    Ok(size)
}

fn background(node: &Node) -> Result<[f32; 3], Diagnostic> {
    match colour(node)? {
        (rgb, None) => Ok(rgb),
        _ => Err(node
            .error("a background is opaque", "has an opacity")
            .with_note("write a colour of six digits, \"#rrggbb\"")),
    }
}

/// RGB, and opacity if it was written.
fn colour(node: &Node) -> Result<([f32; 3], Option<f32>), Diagnostic> {
    const COLOUR: &str = "a colour, \"#rrggbb\" or \"#rrggbbaa\"";
    let Value::Text(text) = &node.value else { return Err(node.wrong_type(COLOUR)) };
    parse_colour(text).ok_or_else(|| node.not_allowed(COLOUR))
}
