//! `shaders/view/view.wgsl` and `shaders/camera`: the ray of a pixel, and its crossing of the drawn box.

use glam::Vec3;

use super::Mirror;

/// Smallest magnitude of a direction's component. It prevents division by zero for a ray along an axis.
const TINY: f32 = 1e-9;

/// A ray in voxel coordinates. Its direction has unit length in the world.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Ray {
    /// Start.
    pub origin: Vec3,
    /// Direction.
    pub direction: Vec3,
}

/// The part of a ray within the drawn box, in voxel lengths from its origin. Empty if `far <= near`.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Crossing {
    /// Where it enters, at least 0.
    pub near: f32,
    /// Where it leaves.
    pub far: f32,
}

impl Mirror<'_> {
    /// The ray of a pixel.
    #[must_use]
    pub fn pixel_ray(&self, [x, y]: [u32; 2]) -> Ray {
        let rays = &self.rays;
        let [u, v] = rays.pixel(x, y, self.view.size);
        let origin = rays.origin + rays.origin_right * u + rays.origin_up * v;
        let direction = rays.direction + rays.direction_right * u + rays.direction_up * v;
        Ray { origin, direction: direction / (direction * rays.voxel_size).length() }
    }

    /// The part of a ray within the drawn box.
    #[must_use]
    pub fn crossing(&self, ray: &Ray) -> Crossing {
        let tiny = ray.direction.abs().cmplt(Vec3::splat(TINY));
        let slope = Vec3::select(tiny, Vec3::splat(TINY), ray.direction);
        let [low, high] = self.bounds;
        let (t0, t1) = ((low - ray.origin) / slope, (high - ray.origin) / slope);
        Crossing { near: t0.min(t1).max_element().max(0.0), far: t0.max(t1).min_element() }
    }
}
