//! Distance between the isosurfaces of the original and of the decoded volume, at the edges of a scene's transfer
//! function. The values are the drawn ones: nothing is rounded, and a colour is the number that its scene's transfer
//! function maps. If a table of colours gives the opacity, there are no edges.

use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::BTreeMap;

use cvr_core::metrics::isosurface::{self, SurfaceDistance};
use cvr_core::render::{ColourOpacity, DecodedFrame, Filter};
use cvr_core::volume::FrameIndex;

use crate::experiment::records::record::Record;
use crate::experiment::running::encoded::Encoded;
use crate::experiment::running::stage::Stage;

/// Distances in the frames of one stream, by scene and frame. Each is measured once for all cells.
#[derive(Debug, Default)]
pub struct SurfaceDistances(RefCell<BTreeMap<(String, FrameIndex), Option<SurfaceDistance>>>);

impl SurfaceDistances {
    fn of(
        &self,
        encoded: &Encoded,
        stage: &Stage<'_>,
        frame: FrameIndex,
    ) -> Result<Option<SurfaceDistance>, String> {
        let key = (stage.scene().to_owned(), frame);
        let known = self.0.borrow().get(&key).copied();
        if let Some(known) = known {
            return Ok(known);
        }
        let distance = distance(stage, frame, &*encoded.frame_of_full_size(frame)?)?;
        self.0.borrow_mut().insert(key, distance);
        Ok(distance)
    }
}

/// Enters the distance over all frames that the scene draws.
///
/// # Errors
/// A sentence, when a frame cannot be decoded.
pub fn enter(
    record: &mut Record,
    known: &SurfaceDistances,
    encoded: &Encoded,
    stage: &Stage<'_>,
) -> Result<(), String> {
    let mut distances = Vec::new();
    for frame in stage.frames().iter() {
        distances.extend(known.of(encoded, stage, frame)?);
    }
    let pooled = SurfaceDistance::pooled(distances);
    record.isosurface_distance_voxels = pooled.map(|d| d.mean);
    record.isosurface_max_distance_voxels = pooled.map(|d| d.max);
    if pooled.is_some_and(|d| d.mean.is_infinite()) {
        record.remark("an isosurface is in one of original and decoded volume alone");
    }
    Ok(())
}

/// The distance in one frame; `decoded` is that frame.
fn distance(
    stage: &Stage<'_>,
    frame: FrameIndex,
    decoded: &DecodedFrame,
) -> Result<Option<SurfaceDistance>, String> {
    let view = stage.view(Filter::Linear)?;
    let isovalues = match &view.colour_opacity {
        ColourOpacity::Table(_) if decoded.layout().channels == 3 => Vec::new(),
        _ => isosurface::edges(&view.transfer_function),
    };
    if isovalues.is_empty() {
        return Ok(None);
    }
    let original = stage.original(frame)?;
    let [original, decoded_values] =
        [original.as_ref(), decoded].map(|frame| scalars(frame, &view.colour_opacity));
    let extent = decoded.layout().extent.to_array();
    Ok(isosurface::distance(&original, &decoded_values, extent, &isovalues))
}

/// One number per voxel: a scalar itself, or for a colour the number that the transfer function maps.
fn scalars<'a>(frame: &'a DecodedFrame, opacity: &ColourOpacity) -> Cow<'a, [f32]> {
    if frame.layout().channels == 1 {
        return Cow::Borrowed(frame.values());
    }
    let weights = opacity.weights().to_array();
    let number = |rgb: &[f32]| rgb.iter().zip(weights).map(|(v, w)| v * w).sum();
    Cow::Owned(frame.values().chunks_exact(3).map(number).collect())
}
