//! Proxy geometry: polygons that cover each slab of the drawn box in the picture. A polygon may cover more, but never
//! less. The shader decides what a fragment shows.

use cvr_core::render::{Projection, ProxyVertex, RayFrame, View};
use cvr_core::volume::VolumeLayout;
use glam::{DVec2, DVec3};

use crate::Geometry;
use crate::slabs::{Slabs, corner_rays, corners};

/// Points nearer to the eye than this, in voxel lengths, are not projected.
const NEAR: f64 = 1e-3;
/// Polygons grow by this many pixels, so that rounding misses no pixel centre.
const MARGIN_PIXELS: f64 = 0.5;

/// Triangles that cover every slab, the farthest slab first.
pub fn proxies(slabs: &Slabs, view: &View, layout: &VolumeLayout, rays: &RayFrame) -> Vec<ProxyVertex> {
    let picture = Picture::new(view, rays);
    let voxel_size = rays.voxel_size.as_dvec3();
    let bounds = view.bounds(layout.extent).map(|corner| corner.as_dvec3() * voxel_size);
    // Shells curve away from their tangent plane, most at the picture's corners.
    let bulge = corner_rays(rays, view.size).iter().map(|ray| 1.0 / ray.length()).fold(1.0, f64::min);
    let mut vertices = Vec::new();
    for slice in (0..slabs.count).rev() {
        let begin = f64::from(slabs.first) + f64::from(slice) * f64::from(slabs.thickness);
        let end = begin + f64::from(slabs.thickness);
        let eye_distance = picture.forward.dot(picture.eye);
        let points = match slabs.geometry {
            Geometry::Planes => picture.between(bounds, begin - eye_distance, end - eye_distance),
            Geometry::Shells => picture.between(bounds, begin * bulge, end),
            Geometry::Axis => {
                let [low, high] = layer(bounds, slabs.normal.as_dvec3(), begin, end);
                corners(low, high).map(|corner| picture.seen(corner)).to_vec()
            }
        };
        let polygon = picture.polygon(&points);
        for pair in polygon.get(1..).unwrap_or(&[]).windows(2) {
            for corner in [polygon[0], pair[0], pair[1]] {
                vertices.push(ProxyVertex { position: corner.as_vec2().to_array(), slice });
            }
        }
    }
    vertices
}

/// The part of a box between two distances along an axis of the volume.
fn layer([low, high]: [DVec3; 2], normal: DVec3, begin: f64, end: f64) -> [DVec3; 2] {
    let is_axis = normal.abs().cmpgt(DVec3::ZERO);
    let sign = normal.to_array().into_iter().sum::<f64>().signum();
    let (begin, end) =
        (DVec3::splat((begin * sign).min(end * sign)), DVec3::splat((begin * sign).max(end * sign)));
    [DVec3::select(is_axis, low.max(begin), low), DVec3::select(is_axis, high.min(end), high)]
}

/// The image plane: right, up and depth of a point of the world.
struct Picture {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    perspective: bool,
    /// Normalised device coordinates per unit of the image plane.
    scale: DVec2,
    margin: DVec2,
}

impl Picture {
    fn new(view: &View, rays: &RayFrame) -> Self {
        let voxel_size = rays.voxel_size.as_dvec3();
        let perspective = view.camera.projection == Projection::Perspective;
        let (right, up) = match view.camera.projection {
            Projection::Perspective => (rays.direction_right, rays.direction_up),
            Projection::Orthographic => (rays.origin_right, rays.origin_up),
        };
        // Converts a point's offset to image-plane units: u = offset · right / |right|².
        let per_unit = |axis: DVec3| axis / axis.length_squared();
        let size = DVec2::new(f64::from(view.size[0]), f64::from(view.size[1]));
        Self {
            eye: rays.origin.as_dvec3() * voxel_size,
            right: per_unit(right.as_dvec3() * voxel_size),
            up: per_unit(up.as_dvec3() * voxel_size),
            forward: rays.direction.as_dvec3() * voxel_size,
            perspective,
            scale: 2.0 / (size * f64::from(rays.pixel)),
            margin: 2.0 * MARGIN_PIXELS / size,
        }
    }

    /// A point by its offsets from the eye: right and up (before the division by depth), and depth.
    fn seen(&self, world: DVec3) -> DVec3 {
        let offset = world - self.eye;
        DVec3::new(offset.dot(self.right), offset.dot(self.up), offset.dot(self.forward))
    }

    /// Corners of the part of a box between two depths.
    fn between(&self, [low, high]: [DVec3; 2], begin: f64, end: f64) -> Vec<DVec3> {
        let corners = corners(low, high).map(|corner| self.seen(corner));
        let mut points: Vec<_> = corners.iter().copied().filter(|p| (begin..=end).contains(&p.z)).collect();
        for (i, axis) in
            (0..8).flat_map(|i| [1, 2, 4].map(|axis| (i, axis))).filter(|(i, axis)| i & axis == 0)
        {
            let (a, b) = (corners[i], corners[i | axis]);
            for depth in [begin, end] {
                let t = (depth - a.z) / (b.z - a.z);
                // An edge parallel to the slab has no such point: t is NaN or infinite.
                if (0.0..=1.0).contains(&t) {
                    points.push(a + (b - a) * t);
                }
            }
        }
        points
    }

    /// The convex polygon that covers the points, counter-clockwise, in normalised device coordinates. The whole
    /// picture if a point lies beside or behind the eye.
    fn polygon(&self, points: &[DVec3]) -> Vec<DVec2> {
        if self.perspective && points.iter().any(|p| p.z < NEAR) {
            return [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| DVec2::new(x, y))
                .to_vec();
        }
        let project = |p: &DVec3| p.truncate() * self.scale / if self.perspective { p.z } else { 1.0 };
        // Each point becomes a box of the margin's size, so that a polygon thinner than a pixel still has an area.
        let grown = points.iter().map(project).flat_map(|p| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| p + self.margin * DVec2::new(x, y))
        });
        convex_hull(grown.collect())
    }
}

/// The convex hull, counter-clockwise (Andrew's monotone chain).
fn convex_hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(point - a) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hull_holds_its_points_and_no_more_corners_than_it_needs() {
        let at = |x: f64, y: f64| DVec2::new(x, y);
        let square = vec![at(0.0, 0.0), at(1.0, 1.0), at(0.5, 0.5), at(1.0, 0.0), at(0.0, 1.0), at(0.5, 0.0)];
        let hull = convex_hull(square);
        assert_eq!(hull, vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]);
        assert!(convex_hull(Vec::new()).is_empty());
    }

    #[test]
    fn a_layer_follows_the_direction_of_the_stack() {
        let bounds = [DVec3::ZERO, DVec3::new(4.0, 5.0, 6.0)];
        let [low, high] = layer(bounds, DVec3::Y, 1.0, 2.0);
        assert_eq!((low, high), (DVec3::new(0.0, 1.0, 0.0), DVec3::new(4.0, 2.0, 6.0)));
        let [low, high] = layer(bounds, -DVec3::Z, -2.0, -1.0);
        assert_eq!((low, high), (DVec3::new(0.0, 0.0, 1.0), DVec3::new(4.0, 5.0, 2.0)));
    }
}
