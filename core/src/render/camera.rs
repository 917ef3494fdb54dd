//! The camera, and the rays it sends through a volume.
//!
//! *World* coordinates have their origin at the volume's centre. Their unit is the voxel length (the smallest spacing),
//! so a step along a ray is a step in voxels. The axes are the volume's. z points up in the picture. At azimuth 0 and
//! elevation 0 the camera looks along +y, with x to the right, as one looks at a patient.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::volume::VolumeLayout;

/// How rays run.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Projection {
    /// Rays from one eye.
    #[default]
    Perspective,
    /// Parallel rays.
    Orthographic,
}

/// The camera of a picture.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Degrees around the z axis, counter-clockwise seen from above.
    pub azimuth: f64,
    /// Degrees above the xy plane, −90..=90.
    pub elevation: f64,
    /// Clockwise rotation of the camera around its viewing axis, in degrees. 180 turns the picture upside down.
    pub roll: f64,
    /// Magnification. At 1 the volume's bounding sphere fits into the shorter side of the picture.
    pub zoom: f64,
    /// Parallel or perspective.
    pub projection: Projection,
    /// Angle across the shorter side of a perspective picture at zoom 1, in degrees.
    pub field_of_view: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            azimuth: 30.0,
            elevation: 20.0,
            roll: 0.0,
            zoom: 1.0,
            projection: Projection::Perspective,
            field_of_view: 30.0,
        }
    }
}

/// The rays of a picture, in voxel coordinates (voxel `i` covers `i..i+1`; the volume is `0..extent`).
///
/// The ray of the image-plane point `(u, v)` (see [`RayFrame::pixel`]) starts at `origin + u·origin_right +
/// v·origin_up` and has the direction `direction + u·direction_right + v·direction_up`. Its *world* length is found by
/// multiplying with `voxel_size` per axis.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RayFrame {
    /// Start of the central ray.
    pub origin: Vec3,
    /// Change of the start per unit to the right.
    pub origin_right: Vec3,
    /// Change of the start per unit upwards.
    pub origin_up: Vec3,
    /// Direction of the central ray.
    pub direction: Vec3,
    /// Change of the direction per unit to the right.
    pub direction_right: Vec3,
    /// Change of the direction per unit upwards.
    pub direction_up: Vec3,
    /// Size of a voxel along each axis in world units. The smallest is 1.
    pub voxel_size: Vec3,
    /// Image-plane units per pixel.
    pub pixel: f32,
}

impl Camera {
    /// The rays of a picture of `size` (width, height) pixels.
    #[must_use]
    pub fn rays(&self, layout: &VolumeLayout, size: [u32; 2]) -> RayFrame {
        let voxel_size = DVec3::from_array(layout.spacing) / layout.voxel_length();
        let extent = DVec3::from_array(layout.extent.to_array().map(f64::from));
        let radius = (extent * voxel_size).length() / 2.0;

        let (sin_a, cos_a) = self.azimuth.to_radians().sin_cos();
        let (sin_e, cos_e) = self.elevation.to_radians().sin_cos();
        let level = DVec3::new(cos_a, sin_a, 0.0);
        let forward = DVec3::new(-sin_a * cos_e, cos_a * cos_e, -sin_e);
        let upright = level.cross(forward);
        let (sin_r, cos_r) = self.roll.to_radians().sin_cos();
        let right = level * cos_r - upright * sin_r;
        let up = upright * cos_r + level * sin_r;

        let to_voxels = |world: DVec3| world / voxel_size;
        let half_angle = (self.field_of_view / 2.0).to_radians();
        let distance = match self.projection {
            Projection::Perspective => radius / half_angle.sin(),
            // Parallel rays may start anywhere in front of the volume. The nearer they start, the smaller the rounding
            // errors of positions.
            Projection::Orthographic => radius + 1.0,
        };
        let eye = to_voxels(-forward * distance) + extent / 2.0;
        // u and v are −1..1 across the shorter side of the picture.
        let pixel = (2.0 / f64::from(size[0].min(size[1]))) as f32;
        let zero = Vec3::ZERO;
        let (right, up, forward) = (to_voxels(right), to_voxels(up), to_voxels(forward));
        let frame = RayFrame {
            origin: eye.as_vec3(),
            origin_right: zero,
            origin_up: zero,
            direction: forward.as_vec3(),
            direction_right: zero,
            direction_up: zero,
            voxel_size: voxel_size.as_vec3(),
            pixel,
        };
        match self.projection {
            Projection::Perspective => {
                let reach = half_angle.tan() / self.zoom;
                RayFrame {
                    direction_right: (right * reach).as_vec3(),
                    direction_up: (up * reach).as_vec3(),
                    ..frame
                }
            }
            Projection::Orthographic => {
                let reach = radius / self.zoom;
                RayFrame {
                    origin_right: (right * reach).as_vec3(),
                    origin_up: (up * reach).as_vec3(),
                    ..frame
                }
            }
        }
    }
}

impl RayFrame {
    /// The camera's axes in the world, of unit length: right, up, and back towards the viewer.
    #[must_use]
    pub fn axes(&self) -> [Vec3; 3] {
        // One summand is zero: parallel rays differ in origin, perspective rays in direction.
        let right = self.direction_right + self.origin_right;
        let up = self.direction_up + self.origin_up;
        [right, up, -self.direction].map(|axis| (axis * self.voxel_size).normalize())
    }

    /// Image-plane point of a pixel's centre.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32, size: [u32; 2]) -> [f32; 2] {
        let u = (x as f32 + 0.5 - size[0] as f32 * 0.5) * self.pixel;
        let v = (size[1] as f32 * 0.5 - y as f32 - 0.5) * self.pixel;
        [u, v]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Extent, SampleType};

    fn layout() -> VolumeLayout {
        let mut layout = VolumeLayout::scalar(Extent::new(10, 20, 30).unwrap(), SampleType::U8);
        layout.spacing = [2.0, 1.0, 4.0];
        layout
    }

    #[test]
    fn the_central_ray_meets_the_centre() {
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let camera = Camera { projection, ..Camera::default() };
            let rays = camera.rays(&layout(), [64, 64]);
            let centre = Vec3::new(5.0, 10.0, 15.0);
            let to_centre = (centre - rays.origin).normalize();
            assert!(to_centre.distance(rays.direction.normalize()) < 1e-5);
            assert!(((rays.direction * rays.voxel_size).length() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn the_axes_are_orthonormal_in_the_world() {
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let camera = Camera { projection, roll: 17.0, ..Camera::default() };
            let [right, up, back] = camera.rays(&layout(), [64, 48]).axes();
            assert!(right.cross(up).distance(back) < 1e-5);
            assert!([right, up, back].iter().all(|axis| (axis.length() - 1.0).abs() < 1e-6));
        }
    }

    #[test]
    fn a_quarter_roll_turns_the_cameras_right_side_down() {
        let camera = Camera { azimuth: 0.0, elevation: 0.0, roll: 90.0, ..Camera::default() };
        let rays = camera.rays(&layout(), [64, 64]);
        assert!(rays.direction_right.z < 0.0 && rays.direction_right.x.abs() < 1e-6);
        assert!(rays.direction_up.x > 0.0 && rays.direction_up.z.abs() < 1e-6);
    }

    #[test]
    fn azimuth_zero_looks_along_y_with_x_to_the_right_and_z_up() {
        let camera = Camera { azimuth: 0.0, elevation: 0.0, ..Camera::default() };
        let rays = camera.rays(&layout(), [64, 64]);
        assert!(rays.direction.y > 0.0 && rays.direction.x.abs() < 1e-6 && rays.direction.z.abs() < 1e-6);
        assert!(rays.direction_right.x > 0.0 && rays.direction_up.z > 0.0);
    }
}
