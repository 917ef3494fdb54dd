//! Shading: the model of Blinn and Phong over the gradient of the data values, and its light.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::RayFrame;

/// Blinn–Phong (Blinn 1977) with one white light. The normal is the gradient of the data values, by central differences
/// one voxel apart. Both sides of a surface are lit.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shading {
    /// Fraction of a sample's colour without light, `0.0..=1.0`.
    pub ambient: f32,
    /// Fraction of a sample's colour that light adds at normal incidence, `0.0..=1.0`.
    pub diffuse: f32,
    /// White that the highlight adds at its brightest, `0.0..=1.0`.
    pub specular: f32,
    /// Exponent of the highlight, within [`Shading::SHININESS`]. A larger exponent makes a smaller highlight.
    pub shininess: f32,
    /// What the light follows.
    pub light: Light,
    /// Direction towards the light. Not zero; its length is ignored. For [`Light::Camera`]: right, up, towards the
    /// viewer. For [`Light::Fixed`]: the volume's x, y, z.
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

    /// Threshold of gradients, as a fraction of the transfer function's domain per voxel length. Gradients far above it
    /// count in full; below it they fade out. It is about one step of 8-bit samples, and of the 8-bit weights of
    /// texture units: a smaller gradient would have the direction of rounding errors.
    pub const FLAT: f32 = 0.004;

    /// Whether these components point anywhere.
    #[must_use]
    pub fn is_direction(direction: [f32; 3]) -> bool {
        direction.iter().all(|c| c.is_finite()) && direction.iter().any(|c| *c != 0.0)
    }

    /// Unit vector towards the light, in world coordinates.
    #[must_use]
    pub fn towards_light(&self, rays: &RayFrame) -> Vec3 {
        // Double precision holds the squares of very long and very short vectors.
        let [x, y, z] = DVec3::from_array(self.direction.map(f64::from)).normalize().as_vec3().to_array();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Camera;
    use crate::volume::{Extent, SampleType, VolumeLayout};

    fn towards(light: Light, direction: [f32; 3], camera: Camera) -> Vec3 {
        let mut layout = VolumeLayout::scalar(Extent::new(10, 20, 30).unwrap(), SampleType::U8);
        layout.spacing = [2.0, 1.0, 4.0];
        Shading { light, direction, ..Shading::default() }.towards_light(&camera.rays(&layout, [64, 64]))
    }

    #[test]
    fn a_light_follows_the_camera_or_the_volume() {
        // At azimuth 0 the camera looks along y, with x to the right and z up.
        let front = Camera { azimuth: 0.0, elevation: 0.0, ..Camera::default() };
        let side = Camera { azimuth: 90.0, ..front };
        for camera in [front, side] {
            assert!(towards(Light::Fixed, [0.0, 3.0, 0.0], camera).distance(Vec3::Y) < 1e-6);
        }
        assert!(towards(Light::Camera, [0.0, 0.0, 2.0], front).distance(-Vec3::Y) < 1e-6);
        assert!(towards(Light::Camera, [1.0, 0.0, 0.0], front).distance(Vec3::X) < 1e-6);
        assert!(towards(Light::Camera, [1.0, 0.0, 0.0], side).distance(Vec3::X) > 1.0);
    }

    #[test]
    fn the_length_of_a_direction_says_nothing() {
        let camera = Camera::default();
        let expected = towards(Light::Camera, [1.0, 2.0, -3.0], camera);
        for scale in [1e-38, 1e-20, 1e30] {
            let got = towards(Light::Camera, [1.0, 2.0, -3.0].map(|c: f32| c * scale), camera);
            assert!(got.distance(expected) < 1e-6, "{scale}: {got}");
        }
        assert!(!Shading::is_direction([0.0, -0.0, 0.0]) && !Shading::is_direction([0.0, f32::NAN, 1.0]));
        assert!(Shading::is_direction([0.0, 1e-40, 0.0]));
    }
}
