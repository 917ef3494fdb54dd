//! The slabs of slices, and the crossings of rays with them.

use cvr_core::render::mirror::{Crossing, Ray};
use cvr_core::render::{Projection, RayFrame, RenderError, View};
use cvr_core::volume::VolumeLayout;
use encase::ShaderType;
use glam::{DVec3, Vec3};

use crate::Geometry;

/// Most slabs. More would be thinner than any visible difference.
const MOST_SLABS: f64 = 65536.0;
/// Least cosine between a ray and the axis of its stack. Below it, rays would cross slices in the wrong direction or
/// not at all.
const LEAST_COSINE: f64 = 0.02;

/// A stack of slabs of equal thickness.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Slabs {
    /// Shape of the surfaces between slabs. Never shells for parallel rays.
    pub geometry: Geometry,
    /// Distance across flat slabs, in voxel lengths, is `normal · x` for `x` in voxel coordinates.
    pub normal: Vec3,
    /// Position of slab 0: along the normal, or, for shells, the distance from the eye.
    pub first: f32,
    /// In voxel lengths.
    pub thickness: f32,
    /// Number of slabs. Together they hold everything drawn in front of the eye.
    pub count: u32,
}

/// `Slabs` of `shaders/slicing/slicing.wgsl`.
#[derive(ShaderType)]
pub struct SlabsUniform {
    normal: Vec3,
    first: f32,
}

impl Slabs {
    pub fn new(
        geometry: Geometry,
        view: &View,
        layout: &VolumeLayout,
        rays: &RayFrame,
    ) -> Result<Self, RenderError> {
        let geometry = match (geometry, view.camera.projection) {
            (Geometry::Shells, Projection::Orthographic) => Geometry::Planes,
            (geometry, _) => geometry,
        };
        let voxel_size = rays.voxel_size.as_dvec3();
        let forward = rays.direction.as_dvec3() * voxel_size;
        let eye = rays.origin.as_dvec3() * voxel_size;
        let [low, high] = view.bounds(layout.extent).map(|corner| corner.as_dvec3() * voxel_size);
        let normal = match geometry {
            Geometry::Planes | Geometry::Shells => forward,
            Geometry::Axis => main_axis(forward),
        };
        let (mut first, last) = match geometry {
            Geometry::Shells => {
                (nearest(low, high, eye).distance(eye), farthest(low, high, eye).distance(eye))
            }
            Geometry::Planes | Geometry::Axis => extent_along(low, high, normal),
        };
        if geometry == Geometry::Planes && view.camera.projection == Projection::Perspective {
            first = first.max(normal.dot(eye));
        }
        if geometry == Geometry::Axis {
            check_rays(normal, rays, view.size)?;
        }
        let count = ((last - first) / f64::from(view.step_voxels)).ceil().max(1.0);
        if count > MOST_SLABS {
            return Err(RenderError::Unsupported(format!(
                "steps of {} voxels make {count} slices; slicing draws at most {MOST_SLABS}: take larger steps",
                view.step_voxels
            )));
        }
        Ok(Self {
            geometry,
            normal: (normal * voxel_size).as_vec3(),
            first: first as f32,
            thickness: view.step_voxels,
            count: count as u32,
        })
    }

    pub const fn uniform(&self) -> SlabsUniform {
        SlabsUniform { normal: self.normal, first: self.first }
    }

    /// The part of a ray, counted from its entry into the box, that lies in a slab. `travelled` is the distance from
    /// the eye to the entry. `slab_crossing` of the shaders.
    pub fn crossing(&self, entry: &Ray, travelled: f32, slice: u32) -> Crossing {
        let at = |slice: u32| slice as f32 * self.thickness;
        if self.geometry == Geometry::Shells {
            let begin = self.first - travelled;
            return Crossing { near: begin + at(slice), far: begin + at(slice + 1) };
        }
        let begin = self.first - self.normal.dot(entry.origin);
        let speed = self.speed(entry);
        let (a, b) = ((begin + at(slice)) / speed, (begin + at(slice + 1)) / speed);
        Crossing { near: a.min(b), far: a.max(b) }
    }

    /// The slabs that a ray may cross within the length `end` through the box.
    pub fn crossed(&self, entry: &Ray, travelled: f32, end: f32) -> std::ops::Range<u32> {
        let (begin, speed) = match self.geometry {
            Geometry::Shells => (travelled - self.first, 1.0),
            Geometry::Planes | Geometry::Axis => {
                (self.normal.dot(entry.origin) - self.first, self.speed(entry))
            }
        };
        let (a, b) = (begin / self.thickness, (begin + end * speed) / self.thickness);
        // One more on each side. Slabs added by rounding are crossed with length zero.
        let from = (a.min(b) - 1.0).max(0.0) as u32;
        let to = (a.max(b) + 2.0).clamp(0.0, self.count as f32) as u32;
        from.min(to)..to
    }

    /// Speed across the slabs per voxel length of the ray. For a ray parallel to the slabs, a minimum prevents division
    /// by zero.
    fn speed(&self, entry: &Ray) -> f32 {
        let across = self.normal.dot(entry.direction);
        if across.abs() < 1e-9 { 1e-9 } else { across }
    }
}

/// The axis that a direction runs along most, as it runs.
fn main_axis(direction: DVec3) -> DVec3 {
    let size = direction.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        DVec3::X
    } else if size.y >= size.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    axis * direction.dot(axis).signum()
}

/// Checks that every ray runs through the stack in the same direction as the central one. Else slices would be blended
/// in the wrong order.
fn check_rays(normal: DVec3, rays: &RayFrame, size: [u32; 2]) -> Result<(), RenderError> {
    for direction in corner_rays(rays, size) {
        if normal.dot(direction.normalize()) < LEAST_COSINE {
            return Err(RenderError::Unsupported(
                "geometry axis: in so wide a field of view some rays run against the stack; use planes or shells"
                    .to_owned(),
            ));
        }
    }
    Ok(())
}

/// World directions of the rays through the picture's corners, with length 1 along the view direction.
pub fn corner_rays(rays: &RayFrame, [width, height]: [u32; 2]) -> [DVec3; 4] {
    let voxel_size = rays.voxel_size.as_dvec3();
    let half = f64::from(rays.pixel) / 2.0;
    let (u, v) = (f64::from(width) * half, f64::from(height) * half);
    let [forward, right, up] =
        [rays.direction, rays.direction_right, rays.direction_up].map(|d| d.as_dvec3() * voxel_size);
    [(-u, -v), (u, -v), (-u, v), (u, v)].map(|(u, v)| forward + right * u + up * v)
}

/// Corners of a box.
pub fn corners(low: DVec3, high: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let at = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        DVec3::new(at(0), at(1), at(2))
    })
}

fn extent_along(low: DVec3, high: DVec3, normal: DVec3) -> (f64, f64) {
    let distances = corners(low, high).map(|corner| normal.dot(corner));
    let fold = |start, choose: fn(f64, f64) -> f64| distances.into_iter().fold(start, choose);
    (fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max))
}

fn nearest(low: DVec3, high: DVec3, point: DVec3) -> DVec3 {
    point.clamp(low, high)
}

fn farthest(low: DVec3, high: DVec3, point: DVec3) -> DVec3 {
    DVec3::select((point - low).cmpgt(high - point), low, high)
}
