//! `camera`

use crate::diagnostic::Diagnostic;
use crate::pipeline::document::Node;
use crate::pipeline::read::Fields;
use crate::render::{Camera, Projection};

const CAMERA_KEYS: &[&str] = &["azimuth", "elevation", "roll", "zoom", "projection", "field_of_view"];

pub(super) fn read(node: &Node) -> Result<Camera, Diagnostic> {
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
