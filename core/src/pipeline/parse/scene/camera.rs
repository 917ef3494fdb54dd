//! `camera`

use crate::diagnostic::Diagnostic;
use crate::pipeline::document::Node;
use crate::pipeline::keys;
use crate::pipeline::keys::number::{AZIMUTH, ELEVATION, FIELD_OF_VIEW, ROLL, ZOOM};
use crate::pipeline::read::Fields;
use crate::render::{Camera, Projection};

/// Reads the camera of a scene.
pub(super) fn read(node: &Node) -> Result<Camera, Diagnostic> {
    let fields = Fields::of("the camera", node, &keys::scene::camera().names())?;
    let projections = [("perspective", Projection::Perspective), ("orthographic", Projection::Orthographic)];
    Ok(Camera {
        azimuth: fields.number(&AZIMUTH)?,
        elevation: fields.number(&ELEVATION)?,
        roll: fields.number(&ROLL)?,
        zoom: fields.number(&ZOOM)?,
        projection: fields
            .optional("projection", |n| n.one_of("projection", &projections))?
            .unwrap_or(Camera::default().projection),
        field_of_view: fields.number(&FIELD_OF_VIEW)?,
    })
}
