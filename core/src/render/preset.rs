//! Named transfer functions over the range of a volume's values.

use super::ControlPoint;

/// A named transfer function. Its values are fractions of the volume's value range.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Preset {
    /// Name in TOML and on command lines.
    pub name: &'static str,
    /// Its purpose.
    pub doc: &'static str,
    /// Fraction of the value range, straight RGBA.
    points: &'static [(f32, [f32; 4])],
}

impl Preset {
    /// All presets.
    pub const ALL: &'static [Self] = &[
        Self {
            name: "ramp",
            doc: "white, opacity in proportion to the value: a density like an X-ray's",
            points: &[(0.0, [1.0, 1.0, 1.0, 0.0]), (1.0, [1.0, 1.0, 1.0, 0.1])],
        },
        Self {
            name: "surface",
            doc: "one opaque surface a third up the range: judges edges and shading",
            points: &[
                (0.0, [0.93, 0.87, 0.78, 0.0]),
                (0.30, [0.93, 0.87, 0.78, 0.0]),
                (0.36, [0.93, 0.87, 0.78, 0.9]),
                (1.0, [1.0, 0.98, 0.94, 0.9]),
            ],
        },
        Self {
            name: "tissue",
            doc: "soft tissue as a reddish haze, bone or contrast agent bright: CT and MR of bodies",
            points: &[
                (0.0, [0.0, 0.0, 0.0, 0.0]),
                (0.12, [0.55, 0.25, 0.15, 0.0]),
                (0.22, [0.80, 0.45, 0.30, 0.04]),
                (0.38, [0.90, 0.62, 0.45, 0.06]),
                (0.55, [0.96, 0.88, 0.72, 0.45]),
                (1.0, [1.0, 1.0, 0.96, 0.9]),
            ],
        },
        Self {
            name: "heat",
            doc: "black, red, yellow, white with growing opacity: fields of simulations",
            points: &[
                (0.0, [0.0, 0.0, 0.0, 0.0]),
                (0.25, [0.5, 0.0, 0.05, 0.01]),
                (0.5, [0.9, 0.3, 0.0, 0.04]),
                (0.75, [1.0, 0.8, 0.2, 0.12]),
                (1.0, [1.0, 1.0, 0.9, 0.4]),
            ],
        },
        Self {
            name: "signed",
            doc: "blue below the middle of the range, red above, clear at the middle: signed fields",
            points: &[
                (0.0, [0.15, 0.3, 0.95, 0.3]),
                (0.45, [0.55, 0.7, 1.0, 0.0]),
                (0.55, [1.0, 0.7, 0.55, 0.0]),
                (1.0, [0.95, 0.2, 0.1, 0.3]),
            ],
        },
    ];

    /// The preset of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::ALL.iter().find(|preset| preset.name == name)
    }

    /// Its control points. Value 0 is the volume's lowest, 1 its highest.
    #[must_use]
    pub fn control_points(&self) -> Vec<ControlPoint> {
        self.points.iter().map(|&(value, rgba)| ControlPoint { value, rgba }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::TransferFunction;

    #[test]
    fn every_preset_is_a_transfer_function_over_the_whole_range() {
        for preset in Preset::ALL {
            let f = TransferFunction::new(preset.control_points()).unwrap();
            assert_eq!((f.domain().min, f.domain().max), (0.0, 1.0), "{}", preset.name);
            let mut colours = f.points().iter().flat_map(|p| p.rgba);
            assert!(colours.all(|v| (0.0..=1.0).contains(&v)), "{}", preset.name);
            assert!(!f.is_transparent(f.domain()), "{}", preset.name);
            assert_eq!(Preset::named(preset.name), Some(preset));
        }
    }
}
