//! `shading`

use crate::diagnostic::Diagnostic;
use crate::pipeline::document::{Node, Value};
use crate::pipeline::read::Fields;
use crate::render::{Light, Shading};

const SHADING_KEYS: &[&str] = &["ambient", "diffuse", "specular", "shininess", "light", "direction"];

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
    let fields = Fields::of("the shading", node, SHADING_KEYS)?;
    let lights = [("camera", Light::Camera), ("fixed", Light::Fixed)];
    let default = Shading::default();
    let share = |key: &str, default: f32| {
        let share =
            fields.optional(key, |n| n.number("a share from 0 to 1", |x| (0.0..=1.0).contains(&x)))?;
        Ok::<f32, Diagnostic>(share.map_or(default, |x| x as f32))
    };
    let shininess = fields.optional("shininess", |n| {
        n.number("an exponent from 1 to 1000", |x| Shading::SHININESS.contains(&(x as f32)))
            .map_err(|e| e.with_note("the larger, the smaller the highlight"))
    })?;
    Ok(Shading {
        ambient: share("ambient", default.ambient)?,
        diffuse: share("diffuse", default.diffuse)?,
        specular: share("specular", default.specular)?,
        shininess: shininess.map_or(default.shininess, |x| x as f32),
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
