//! Scenes that are hard for codecs: steep transfer functions, an eye inside the volume, a grazing view, a step that is too coarse,
//! and a surface at the level of the noise.

use std::sync::Arc;

use cvr_core::render::{
    Camera, ControlPoint, DecodedFrame, Filter, Shading, TransferFunction, TransferFunctionError, View,
};
use cvr_core::volume::{ValueRange, VolumeLayout};

/// A scene, for any volume.
#[derive(Copy, Clone, Debug)]
pub struct Provocation {
    /// Name in records.
    pub name: &'static str,
    /// What makes it hard.
    pub doc: &'static str,
    kind: Kind,
}

#[derive(Copy, Clone, Debug)]
enum Kind {
    /// Opacity and colour change over this fraction of the range, in its middle.
    Slope(f64),
    Inside,
    Grazing,
    CoarseStep,
    NoiseFloor,
}

impl Provocation {
    /// All scenes, the plainest first.
    pub const ALL: [Self; 9] = [
        Self { name: "slope-1", doc: "colours and opacity over the whole range", kind: Kind::Slope(1.0) },
        Self { name: "slope-3", doc: "over a third of the range, around its middle", kind: Kind::Slope(3.0) },
        Self { name: "slope-10", doc: "over a tenth", kind: Kind::Slope(10.0) },
        Self { name: "slope-30", doc: "over a thirtieth", kind: Kind::Slope(30.0) },
        Self { name: "slope-100", doc: "over a hundredth: all but a surface", kind: Kind::Slope(100.0) },
        Self {
            name: "inside",
            doc: "slope 3, the eye in a corner of the volume, 90 degrees wide",
            kind: Kind::Inside,
        },
        Self {
            name: "grazing",
            doc: "slope 10, lit, seen along the faces of voxels and blocks",
            kind: Kind::Grazing,
        },
        Self {
            name: "coarse-step",
            doc: "slope 3, samples 2 voxels apart: four times too coarse",
            kind: Kind::CoarseStep,
        },
        Self {
            name: "noise-floor",
            doc: "a surface at the commonest value, over a fiftieth of the range",
            kind: Kind::NoiseFloor,
        },
    ];

    /// The view of an original volume's frame. It does not depend on the decoded volume.
    ///
    /// # Errors
    /// When control points coincide, which no finite range makes them.
    pub fn view(
        &self,
        original: &DecodedFrame,
        range: ValueRange,
        filter: Filter,
        edge: u32,
    ) -> Result<View, TransferFunctionError> {
        let range = widened(range);
        let slope = match self.kind {
            Kind::Slope(slope) => slope,
            Kind::Inside | Kind::CoarseStep => 3.0,
            Kind::Grazing => 10.0,
            Kind::NoiseFloor => 50.0,
        };
        let middle = match self.kind {
            Kind::NoiseFloor => commonest(original.values(), range),
            _ => (f64::from(range.min) + f64::from(range.max)) / 2.0,
        };
        // Single precision has no finer steps where an offset dwarfs the range.
        let width = (range.span() / slope).max(4.0 * range.ulp());
        let mut view = View::new(transfer_function(middle, width)?);
        view.size = [edge; 2];
        view.filter = filter;
        view.value_range = range;
        view.termination = 0.999;
        match self.kind {
            Kind::Slope(_) | Kind::NoiseFloor => {}
            Kind::Inside => view.camera = in_a_corner(original.layout()),
            Kind::Grazing => {
                view.camera = Camera { azimuth: 1.5, elevation: 1.0, zoom: 1.4, ..Camera::default() };
                view.shading = Some(Shading::default());
            }
            Kind::CoarseStep => view.step_voxels *= 4.0,
        }
        Ok(view)
    }

    /// The scene of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::ALL.iter().find(|scene| scene.name == name)
    }
}

/// The range, or around a single value as much as lets an error be seen: 1, or a thousandth of the value if that is
/// more.
fn widened(range: ValueRange) -> ValueRange {
    if range.span() > 0.0 {
        return range;
    }
    let by = (f64::from(range.min).abs() / 1000.0).max(1.0);
    let [min, max] = [-by, by].map(|by| (f64::from(range.min) + by) as f32);
    ValueRange { min, max }
}

/// A ramp from blue and clear to bright and dense over `width`, around `middle`.
fn transfer_function(middle: f64, width: f64) -> Result<Arc<TransferFunction>, TransferFunctionError> {
    let point =
        |share: f64, rgba: [f32; 4]| ControlPoint { value: (middle + (share - 0.5) * width) as f32, rgba };
    let points = vec![
        point(0.0, [0.15, 0.30, 0.75, 0.0]),
        point(0.5, [0.85, 0.45, 0.25, 0.12]),
        point(1.0, [1.0, 0.97, 0.85, 0.6]),
    ];
    TransferFunction::new(points).map(Arc::new)
}

/// Middle of the fullest of 64 equal pieces of the range; the lowest of equally full ones.
fn commonest(values: &[f32], range: ValueRange) -> f64 {
    const PIECES: usize = 64;
    let (min, span) = (f64::from(range.min), range.span());
    let mut counts = [0_u32; PIECES];
    for value in values {
        let at = (f64::from(*value) - min) / span * PIECES as f64;
        counts[(at as usize).min(PIECES - 1)] += 1;
    }
    let fullest = counts.iter().enumerate().rev().max_by_key(|(_, n)| **n).map_or(0, |(piece, _)| piece);
    min + (fullest as f64 + 0.5) / PIECES as f64 * span
}

/// A camera whose eye is as near to a corner as a perspective one comes, looking at the volume's middle: at an angle of
/// almost 180 degrees its distance is the radius of the bounding sphere, and zoom narrows what it sees to 90 degrees.
fn in_a_corner(layout: &VolumeLayout) -> Camera {
    const FIELD: f64 = 179.0;
    let size: [f64; 3] = std::array::from_fn(|a| f64::from(layout.extent.to_array()[a]) * layout.spacing[a]);
    let length = size.iter().map(|s| s * s).sum::<f64>().sqrt();
    Camera {
        azimuth: size[0].atan2(size[1]).to_degrees(),
        elevation: (size[2] / length).asin().to_degrees(),
        field_of_view: FIELD,
        zoom: (FIELD / 2.0).to_radians().tan(),
        ..Camera::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::stability::Subject;
    use cvr_core::volume::BrickSource as _;

    fn frame(name: &str, step: usize) -> (DecodedFrame, ValueRange) {
        let subject = Subject::named(name).unwrap();
        let volume = subject.volume(step, 24);
        let values = volume.dense().frame_values(subject.frame);
        (DecodedFrame::new(volume.layout().clone(), values).unwrap(), volume.range())
    }

    #[test]
    fn the_eye_stands_in_a_corner() {
        for (name, step) in [("noise", 0), ("slab", 4), ("odd-sizes", 3)] {
            let (frame, _) = frame(name, step);
            let layout = frame.layout();
            let rays = in_a_corner(layout).rays(layout, [96, 96]);
            let [x, _, z] = layout.extent.to_array().map(|n| n as f32);
            let away =
                rays.origin.to_array().into_iter().zip([x, 0.0, z]).map(|(a, b): (f32, f32)| (a - b).abs());
            assert!(away.fold(0.0, f32::max) < 0.1, "{name}: {}", rays.origin);
            // 45 degrees to each side.
            let side = rays.direction_right.length() / rays.direction.length();
            assert!((side - 1.0).abs() < 1e-3, "{name}: {side}");
        }
    }

    #[test]
    fn every_volume_can_be_drawn_in_every_scene() {
        for subject in Subject::all() {
            for step in 0..subject.steps.len() {
                let (frame, range) = frame(subject.name, step);
                for scene in &Provocation::ALL {
                    let view = scene.view(&frame, range, Filter::Linear, 32);
                    assert!(view.is_ok(), "{} {step} {}", subject.name, scene.name);
                }
            }
        }
    }

    #[test]
    fn slopes_are_as_steep_as_they_say() {
        let (frame, range) = frame("noise", 0);
        let width = |name: &str| {
            let view = Provocation::named(name).unwrap().view(&frame, range, Filter::Linear, 32).unwrap();
            view.transfer_function.domain().span() / range.span()
        };
        for (name, slope) in [("slope-1", 1.0), ("slope-10", 10.0), ("slope-100", 100.0)] {
            assert!((width(name) * slope - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn the_commonest_value_is_found() {
        let values = [0.0, 10.0, 7.0, 7.01, 7.02, 3.0];
        let found = commonest(&values, ValueRange { min: 0.0, max: 10.0 });
        assert!((found - 7.0).abs() < 0.1, "{found}");
    }
}
