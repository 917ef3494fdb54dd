//! `[[scene]]`

use super::super::colour::parse_colour;
use super::super::document::{Node, Value};
use super::super::read::Fields;
use super::super::scene::{Scene, TransferDomain};
use super::name_of;
use crate::diagnostic::Diagnostic;
use crate::render::{Camera, ControlPoint, Projection};

/// Keys of a scene.
pub(in super::super) const SCENE_KEYS: &[&str] = &[
    "name",
    "volumes",
    "size",
    "camera",
    "transfer_function",
    "transfer_function_domain",
    "step_voxels",
    "early_termination",
    "background",
];

/// Keys of a camera.
const CAMERA_KEYS: &[&str] = &["azimuth", "elevation", "roll", "zoom", "projection", "field_of_view"];

/// What a scene has unless the configuration says otherwise.
const DEFAULT_SIZE: [u32; 2] = [256, 256];
const DEFAULT_STEP_VOXELS: f64 = 0.5;
const DEFAULT_EARLY_TERMINATION: f64 = 0.999;

pub(super) fn read(node: &Node) -> Result<Scene, Diagnostic> {
    let fields = Fields::of("the scene", node, SCENE_KEYS)?;
    let name = name_of(&fields, "name = \"front\"")?;
    let what = format!("scene `{name}`");
    let fields = Fields::open(&what, node)?;
    let domains = [TransferDomain::Data, TransferDomain::Range].map(|domain| (domain.name(), domain));
    let domain =
        fields.optional("transfer_function_domain", |n| n.one_of("domain", &domains))?.unwrap_or_default();
    let points =
        fields.require("transfer_function", "transfer_function = [[0, \"#00000000\"], [255, \"#ffffffff\"]]");
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
        camera: fields.optional("camera", camera)?.unwrap_or_default(),
        control_points: control_points(points?, domain)?,
        domain,
        step_voxels: step.unwrap_or(DEFAULT_STEP_VOXELS) as f32,
        early_termination: termination.unwrap_or(DEFAULT_EARLY_TERMINATION) as f32,
        background: fields.optional("background", background)?.unwrap_or([0.0; 3]),
        shading: None,
        clip: None,
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

fn camera(node: &Node) -> Result<Camera, Diagnostic> {
    let fields = Fields::of("the camera", node, CAMERA_KEYS)?;
    let projections = [("perspective", Projection::Perspective), ("orthographic", Projection::Orthographic)];
    let default = Camera::default();
    let number = |key: &str, expected: &str, default: f64, allowed: fn(f64) -> bool| {
        fields.optional(key, |n| n.number(expected, allowed)).map(|x| x.unwrap_or(default))
    };
    Ok(Camera {
        azimuth: number("azimuth", "an angle in degrees", default.azimuth, |_| true)?,
        elevation: number("elevation", "an angle from -90 to 90 degrees", default.elevation, |x| {
            (-90.0..=90.0).contains(&x)
        })?,
        roll: number("roll", "an angle in degrees", default.roll, |_| true)?,
        zoom: number("zoom", "a magnification above 0 (1 fits the volume)", default.zoom, |x| x > 0.0)?,
        projection: fields
            .optional("projection", |n| n.one_of("projection", &projections))?
            .unwrap_or(default.projection),
        field_of_view: number(
            "field_of_view",
            "an angle above 0 and below 180 degrees",
            default.field_of_view,
            |x| x > 0.0 && x < 180.0,
        )?,
    })
}

fn control_points(node: &Node, domain: TransferDomain) -> Result<Vec<ControlPoint>, Diagnostic> {
    const POINT: &str = "a control point, [value, \"#rrggbbaa\"]";
    let nodes = node.list("a list of control points, [[value, \"#rrggbbaa\"], …]")?;
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
