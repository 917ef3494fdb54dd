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
use crate::pipeline::read::Fields;
use crate::pipeline::scene::Scene;

/// Keys of a scene.
pub(in crate::pipeline) const SCENE_KEYS: &[&str] = &[
    "name",
    "volumes",
    "size",
    "camera",
    "transfer_function",
    "transfer_function_domain",
    "opacity",
    "frame",
    "shading",
    "clip_box",
    "step_voxels",
    "early_termination",
    "background",
];

/// What a scene has unless the configuration says otherwise.
const DEFAULT_SIZE: [u32; 2] = [256, 256];
const DEFAULT_STEP_VOXELS: f64 = 0.5;
const DEFAULT_EARLY_TERMINATION: f64 = 0.999;

pub(super) fn read(node: &Node) -> Result<Scene, Diagnostic> {
    let fields = Fields::of("the scene", node, SCENE_KEYS)?;
    let name = name_of(&fields, "name = \"front\"")?;
    let what = format!("scene `{name}`");
    let fields = Fields::open(&what, node)?;
    let (control_points, domain) = transfer_function::read(&fields)?;
    let step = fields.optional("step_voxels", |n| {
        n.number("a step from 0.01 to 1000 voxels", |x| Scene::STEP_VOXELS.contains(&(x as f32)))
    })?;
    let termination = fields.optional("early_termination", |n| {
        n.number("an opacity above 0 and at most 1", |x| x as f32 > 0.0 && x <= 1.0)
            .map_err(|e| e.with_note("1 = every ray runs to its end"))
    })?;
    let volumes =
        fields.optional("volumes", |n| n.one_or_many("volume", |item| item.text().map(str::to_owned)))?;
    Ok(Scene {
        volumes,
        size: fields.optional("size", size)?.unwrap_or(DEFAULT_SIZE),
        camera: fields.optional("camera", camera::read)?.unwrap_or_default(),
        control_points,
        domain,
        step_voxels: step.unwrap_or(DEFAULT_STEP_VOXELS) as f32,
        early_termination: termination.unwrap_or(DEFAULT_EARLY_TERMINATION) as f32,
        background: fields.optional("background", background)?.unwrap_or([0.0; 3]),
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
