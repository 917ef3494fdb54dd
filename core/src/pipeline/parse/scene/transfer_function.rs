//! `transfer_function` and `transfer_function_domain`

use super::colour;
use crate::diagnostic::Diagnostic;
use crate::pipeline::document::{Node, Value};
use crate::pipeline::read::Fields;
use crate::pipeline::scene::TransferDomain;
use crate::render::{ControlPoint, Preset, TransferFunction};

/// Reads control points and the meaning of their values.
pub(super) fn read(fields: &Fields<'_>) -> Result<(Vec<ControlPoint>, TransferDomain), Diagnostic> {
    let domains = [TransferDomain::Data, TransferDomain::Range].map(|domain| (domain.name(), domain));
    let domain = fields.optional("transfer_function_domain", |n| n.one_of("domain", &domains))?;
    let node = fields
        .require("transfer_function", "transfer_function = [[0, \"#00000000\"], [255, \"#ffffffff\"]]")?;
    if !matches!(node.value, Value::Text(_)) {
        let domain = domain.unwrap_or_default();
        return Ok((control_points(node, domain)?, domain));
    }
    let presets: Vec<(&str, &Preset)> = Preset::ALL.iter().map(|preset| (preset.name, preset)).collect();
    let preset = node.one_of("preset", &presets)?;
    if let (Some(TransferDomain::Data), Some(written)) = (domain, fields.get("transfer_function_domain")) {
        let message = format!("preset `{}` lies over the range of the volume's values", preset.name);
        return Err(written
            .error(message, "and not over data values")
            .with_secondary(node.place.clone(), "the preset")
            .with_note("leave `transfer_function_domain` out, or write control points in data values"));
    }
    Ok((preset.control_points(), TransferDomain::Range))
}

fn control_points(node: &Node, domain: TransferDomain) -> Result<Vec<ControlPoint>, Diagnostic> {
    const POINT: &str = "a control point, [value, \"#rrggbbaa\"]";
    let nodes =
        node.list("a list of control points, [[value, \"#rrggbbaa\"], …], or the name of a preset")?;
    let most = TransferFunction::MAX_POINTS;
    if let Some(beyond) = nodes.get(most) {
        let message =
            format!("a transfer function has at most {most} control points, this has {}", nodes.len());
        return Err(beyond
            .error(message, "one too many")
            .with_note("leave out points that lie on the line between their neighbours"));
    }
    let mut points: Vec<ControlPoint> = Vec::new();
    let mut before: Option<&Node> = None;
    for item in nodes {
        let [value_node, colour_node] = item.array::<2>(POINT)?;
        let value = match domain {
            TransferDomain::Data => value_node.number("a data value", |x| (x as f32).is_finite()),
            TransferDomain::Range => {
                value_node.number("a value from 0 to 1", |x| (0.0..=1.0).contains(&x)).map_err(|e| {
                    e.with_note("in the domain \"range\", 0 is the volume's lowest value and 1 its highest")
                })
            }
        }? as f32;
        let ([r, g, b], a) = colour(colour_node)?;
        if let (Some(last), Some(before)) = (points.last(), before)
            && value < last.value
        {
            return Err(value_node
                .error("control points are out of order", "below the value before it")
                .with_secondary(before.place.clone(), "the value before")
                .with_note("sort the points by value; two points of one value make a step"));
        }
        points.push(ControlPoint { value, rgba: [r, g, b, a.unwrap_or(1.0)] });
        before = Some(value_node);
    }
    match points.as_slice() {
        [first, .., last] if first.value < last.value => Ok(points),
        [_, _, ..] => Err(node
            .error("all control points lie at one value", "no two values differ")
            .with_note("spread the points over several values")),
        _ => Err(node
            .error(
                format!("a transfer function needs two control points, this has {}", points.len()),
                "too few",
            )
            .with_note("write, for instance, [[0, \"#00000000\"], [255, \"#ffffffff\"]]")),
    }
}
