//! Keys of a scene that take one number. Parser, schema and command line read them from this list.

use super::shape::{Bounds, Key, Shape};
use crate::render::{Camera, Shading};

/// A key that takes one number.
#[derive(Copy, Clone, Debug)]
pub struct NumberKey {
    /// Name in TOML.
    pub name: &'static str,
    /// Its effect: a sentence without a full stop.
    pub doc: &'static str,
    /// Unit. Empty if it has none.
    pub unit: &'static str,
    /// The expected value, for messages.
    pub(in crate::pipeline) expected: &'static str,
    pub(in crate::pipeline) bounds: fn() -> Bounds,
    default: fn() -> f64,
}

impl NumberKey {
    /// Whether this number is allowed.
    #[must_use]
    pub fn allows(&self, number: f64) -> bool {
        number.is_finite() && (self.bounds)().hold(number)
    }

    /// Whether a single-precision number is allowed, read as it is printed.
    #[must_use]
    pub fn allows_single(&self, number: f32) -> bool {
        self.allows(single(number))
    }

    /// The key in the table of keys.
    pub(in crate::pipeline) fn key(&self) -> Key {
        let default = format!("{:?}", self.default());
        Key::with_default(self.name, Shape::Number((self.bounds)()), default, self.doc).unit(self.unit)
    }

    /// Its default.
    #[must_use]
    pub fn default(&self) -> f64 {
        (self.default)()
    }
}

/// A single-precision number as it is printed.
fn single(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

/// `camera.azimuth`
pub const AZIMUTH: NumberKey = NumberKey {
    name: "azimuth",
    doc: "Turn of the eye around the z axis, counter-clockwise seen from above",
    unit: "degrees",
    expected: "an angle in degrees",
    bounds: || Bounds::ANY,
    default: || Camera::default().azimuth,
};

/// `camera.elevation`
pub const ELEVATION: NumberKey = NumberKey {
    name: "elevation",
    doc: "Height of the eye above the xy plane",
    unit: "degrees",
    expected: "an angle from -90 to 90 degrees",
    bounds: || Bounds::range(-90.0, 90.0),
    default: || Camera::default().elevation,
};

/// `camera.roll`
pub const ROLL: NumberKey = NumberKey {
    name: "roll",
    doc: "Turn of the camera clockwise around its own axis",
    unit: "degrees",
    expected: "an angle in degrees",
    bounds: || Bounds::ANY,
    default: || Camera::default().roll,
};

/// `camera.zoom`
pub const ZOOM: NumberKey = NumberKey {
    name: "zoom",
    doc: "Magnification; 1 fits the volume's bounding sphere",
    unit: "",
    expected: "a magnification above 0 (1 fits the volume)",
    bounds: || Bounds::POSITIVE,
    default: || Camera::default().zoom,
};

/// `camera.field_of_view`
pub const FIELD_OF_VIEW: NumberKey = NumberKey {
    name: "field_of_view",
    doc: "Angle across the shorter side of a perspective picture at zoom 1",
    unit: "degrees",
    expected: "an angle above 0 and below 180 degrees",
    bounds: || Bounds { above: Some(0.0), below: Some(180.0), ..Bounds::ANY },
    default: || Camera::default().field_of_view,
};

/// `step_voxels`
pub const STEP_VOXELS: NumberKey = NumberKey {
    name: "step_voxels",
    doc: "Distance between samples along a ray, or between slices",
    unit: "voxels",
    expected: "a step from 0.01 to 1000 voxels",
    // Below, a picture takes minutes and shows nothing more. Above, a ray misses the volume.
    bounds: || Bounds::range(0.01, 1000.0),
    default: || 0.5,
};

/// `early_termination`
pub const EARLY_TERMINATION: NumberKey = NumberKey {
    name: "early_termination",
    doc: "Opacity at which a ray ends; 1 = never. Slices do not end early",
    unit: "",
    expected: "an opacity above 0 and at most 1",
    bounds: || Bounds { above: Some(0.0), max: Some(1.0), ..Bounds::ANY },
    default: || 0.999,
};

/// `shading.ambient`
pub const AMBIENT: NumberKey =
    share("ambient", "Share of its colour that a sample shows without light", || {
        single(Shading::default().ambient)
    });

/// `shading.diffuse`
pub const DIFFUSE: NumberKey =
    share("diffuse", "Share of its colour that light adds where it meets the surface upright", || {
        single(Shading::default().diffuse)
    });

/// `shading.specular`
pub const SPECULAR: NumberKey = share("specular", "White that the highlight adds at its brightest", || {
    single(Shading::default().specular)
});

/// `shading.shininess`
pub const SHININESS: NumberKey = NumberKey {
    name: "shininess",
    doc: "Exponent of the highlight: the larger, the smaller it is",
    unit: "",
    expected: "an exponent from 1 to 1000",
    bounds: || Bounds::range(single(*Shading::SHININESS.start()), single(*Shading::SHININESS.end())),
    default: || single(Shading::default().shininess),
};

const fn share(name: &'static str, doc: &'static str, default: fn() -> f64) -> NumberKey {
    NumberKey { name, doc, unit: "", expected: "a share from 0 to 1", bounds: || Bounds::SHARE, default }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_either_precision_reach_both_ends() {
        for (key, least, most) in [(STEP_VOXELS, 0.01, 1000.0), (SHININESS, 1.0, 1000.0), (AMBIENT, 0.0, 1.0)]
        {
            assert!(key.allows(least) && key.allows(most), "{}", key.name);
            assert!(key.allows_single(least as f32) && key.allows_single(most as f32), "{}", key.name);
            assert!(!key.allows(least - 1e-9) && !key.allows(most + 1e-9), "{}", key.name);
        }
        assert!(!ZOOM.allows(0.0) && ZOOM.allows(1e-9) && !ZOOM.allows(f64::INFINITY));
        assert!(!FIELD_OF_VIEW.allows(180.0) && FIELD_OF_VIEW.allows(179.9));
        assert!(!ROLL.allows(f64::NAN) && ROLL.allows(-1e6));
        assert!(!EARLY_TERMINATION.allows_single(0.0) && EARLY_TERMINATION.allows_single(1.0));
    }
}
