//! Shading: Blinn and Phong's model over the gradient of the data values, and where its light stands.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::RayFrame;

/// Blinn–Phong (Blinn 1977) with one white light. The normal is the gradient of the data values by central
/// differences one voxel apart; both of its sides are lit.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shading {
    /// Share of a sample's colour that it shows without light, `0.0..=1.0`.
    pub ambient: f32,
    /// Share of a sample's colour that light adds where it meets the surface upright, `0.0..=1.0`.
    pub diffuse: f32,
    /// White that the highlight adds at its brightest, `0.0..=1.0`.
    pub specular: f32,
    /// Exponent of the highlight, within [`Shading::SHININESS`]; the larger, the smaller the highlight.
    pub shininess: f32,
    /// What the light follows.
    pub light: Light,
    /// Towards the light; not zero, its length says nothing. Of [`Light::Camera`]: right, up, towards the viewer.
    /// Of [`Light::Fixed`]: the volume's x, y, z.
    pub direction: [f32; 3],
}

/// What the light follows.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Light {
    /// The camera.
    #[default]
    Camera,
    /// The volume.
    Fixed,
}

impl Default for Shading {
    /// A light over the viewer's left shoulder.
    fn default() -> Self {
        Self {
            ambient: 0.35,
            diffuse: 0.65,
            specular: 0.25,
            shininess: 32.0,
            light: Light::Camera,
            direction: [-0.4, 0.6, 1.0],
        }
    }
}

impl Shading {
    /// Exponents that make sense.
    pub const SHININESS: std::ops::RangeInclusive<f32> = 1.0..=1000.0;

    /// A gradient counts in full where it exceeds this share of the transfer function's domain per voxel length by
    /// far, and fades out below it: the direction of a gradient of nothing but rounding would be noise.
    pub const FLAT: f32 = 0.002;

    /// Towards the light in the world, of unit length.
    #[must_use]
    pub fn towards_light(&self, rays: &RayFrame) -> Vec3 {
        let [x, y, z] = self.direction;
        let world = match self.light {
            Light::Fixed => Vec3::new(x, y, z),
            Light::Camera => {
                let [right, up, back] = rays.axes();
                right * x + up * y + back * z
            }
        };
        world.normalize()
    }
}
