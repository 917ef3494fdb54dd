//! `shading`

use crate::diagnostic::Diagnostic;
use crate::pipeline::document::{Node, Value};
use crate::pipeline::keys;
use crate::pipeline::keys::number::{AMBIENT, DIFFUSE, SHININESS, SPECULAR};
use crate::pipeline::read::Fields;
use crate::render::{Light, Shading};

/// `None` is unlit.
pub(super) fn read(node: &Node) -> Result<Option<Shading>, Diagnostic> {
    match node.value {
        Value::Boolean(lit) => Ok(lit.then(Shading::default)),
        Value::Table(_) => table(node).map(Some),
        _ => Err(node
            .wrong_type("true, false or a table")
            .with_note("write, for instance, { ambient = 0.3, light = \"fixed\", direction = [1, -1, 2] }")),
    }
}

fn table(node: &Node) -> Result<Shading, Diagnostic> {
    let fields = Fields::of("the shading", node, &keys::scene::shading().names())?;
    let lights = [("camera", Light::Camera), ("fixed", Light::Fixed)];
    let default = Shading::default();
    let larger = |e: Diagnostic| e.with_note("the larger, the smaller the highlight");
    let shininess = fields.number(&SHININESS).map_err(larger)? as f32;
    Ok(Shading {
        ambient: fields.number(&AMBIENT)? as f32,
        diffuse: fields.number(&DIFFUSE)? as f32,
        specular: fields.number(&SPECULAR)? as f32,
        shininess,
        light: fields.optional("light", |n| n.one_of("light", &lights))?.unwrap_or(default.light),
        direction: fields.optional("direction", direction)?.unwrap_or(default.direction),
    })
}

fn direction(node: &Node) -> Result<[f32; 3], Diagnostic> {
    let mut direction = [0.0; 3];
    for (component, item) in direction.iter_mut().zip(node.array::<3>("a direction, [x, y, z]")?) {
        *component = item.number("a number", |x| (x as f32).is_finite())? as f32;
    }
    if Shading::is_direction(direction) {
        return Ok(direction);
    }
    Err(node
        .error("light comes from no direction", "of no length")
        .with_note("[x, y, z] points towards the light, as far as you like: [-0.4, 0.6, 1]")
        .with_note("x, y, z are right, up, towards the viewer; with light = \"fixed\", the volume's axes"))
}
