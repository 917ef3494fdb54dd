//! The raycaster on the CPU: `raycasting.wgsl` and the modules that it calls, function by function.

use cvr_core::render::{Filter, Image, RayFrame, RenderError, View, Voxels};
use glam::{IVec3, Vec3};
use rayon::prelude::*;

/// Opacities stay below this; see `opacity.wgsl`.
const OPAQUE: f32 = 0.99999;
/// Directions smaller than this count as this, lest a ray along an axis divide by zero.
const TINY: f32 = 1e-9;

/// Draws every pixel, rows in parallel.
pub fn draw(view: &View, voxels: &dyn Voxels, image: &mut Image) -> Result<(), RenderError> {
    assert_eq!(image.size(), view.size, "picture of another size than the view");
    let rays = view.camera.rays(voxels.layout(), view.size);
    let width = view.size[0] as usize;
    image.pixels_mut().par_chunks_mut(width).enumerate().try_for_each(|(y, row)| {
        row.iter_mut().zip(0..).try_for_each(|(pixel, x): (_, u32)| {
            *pixel = cast_ray(view, &rays, voxels, [x, y as u32])?;
            Ok(())
        })
    })
}

/// Premultiplied colour and opacity along the ray of a pixel.
fn cast_ray(
    view: &View,
    rays: &RayFrame,
    voxels: &dyn Voxels,
    [x, y]: [u32; 2],
) -> Result<[f32; 4], RenderError> {
    let [u, v] = rays.pixel(x, y, view.size);
    let origin = rays.origin + rays.origin_right * u + rays.origin_up * v;
    let direction = rays.direction + rays.direction_right * u + rays.direction_up * v;
    // One unit of t is one voxel length in the world.
    let direction = direction / (direction * rays.voxel_size).length();

    let slope = Vec3::select(direction.abs().cmplt(Vec3::splat(TINY)), Vec3::splat(TINY), direction);
    let extent = Vec3::from_array(voxels.layout().extent.to_array().map(|e| e as f32));
    let (t0, t1) = ((Vec3::ZERO - origin) / slope, (extent - origin) / slope);
    let (low, high) = (t0.min(t1), t0.max(t1));
    let near = low.max_element().max(0.0);
    let far = high.min_element();

    // From where the ray enters: the smaller the numbers, the less the samples' places depend on rounding.
    let entry = origin + direction * near;
    let end = far - near;

    let mut result = [0.0_f32; 4];
    let mut i = 0_u32;
    // A sample stands for the piece of ray around it. The last piece is cut at the border, so that the picture
    // does not depend on how the division rounds.
    while i as f32 * view.step_voxels < end {
        let start = i as f32 * view.step_voxels;
        let piece = view.step_voxels.min(end - start);
        let value = sample(view.filter, voxels, entry + direction * (start + 0.5 * piece))?;
        let [r, g, b, a] = view.transfer_function.classify(value);
        if a > 0.0 {
            let weight = opacity_over(a, piece) * (1.0 - result[3]);
            // The last sample counts as far as the ray goes: whether it ends here or one sample later, which
            // rounding may decide, is then the same picture.
            let rest = view.termination - result[3];
            for (sum, term) in result.iter_mut().zip([r, g, b, 1.0]) {
                *sum += term * weight.min(rest);
            }
            if weight >= rest {
                break;
            }
        }
        i += 1;
    }
    Ok(result)
}

/// `volume_sample` of a scalar volume.
fn sample(filter: Filter, voxels: &dyn Voxels, x: Vec3) -> Result<f32, RenderError> {
    let last = IVec3::from_array(voxels.layout().extent.to_array().map(|e| e as i32 - 1));
    let clamped = |p: IVec3| p.clamp(IVec3::ZERO, last).as_uvec3().to_array();
    if filter == Filter::Nearest {
        return Ok(voxels.fetch(clamped((x + Filter::NEAREST_TIE).floor().as_ivec3()))?[0]);
    }
    let base = (x - 0.5).floor();
    let t = (x - 0.5) - base;
    let p = base.as_ivec3();
    let cell = voxels.fetch_cell(clamped(p), clamped(p + 1))?;
    Ok(trilinear(cell.map(|corner| corner[0]), t))
}

/// Interpolates along x, then y, then z.
fn trilinear(c: [f32; 8], t: Vec3) -> f32 {
    let c00 = c[0] + (c[1] - c[0]) * t.x;
    let c10 = c[2] + (c[3] - c[2]) * t.x;
    let c01 = c[4] + (c[5] - c[4]) * t.x;
    let c11 = c[6] + (c[7] - c[6]) * t.x;
    let c0 = c00 + (c10 - c00) * t.y;
    let c1 = c01 + (c11 - c01) * t.y;
    c0 + (c1 - c0) * t.z
}

/// Opacity of a piece of ray `length` voxels long, from that of one voxel length.
fn opacity_over(alpha: f32, length: f32) -> f32 {
    1.0 - (1.0 - alpha.min(OPAQUE)).powf(length)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use cvr_core::render::{Camera, ControlPoint, DecodedFrame, Projection, Renderer, TransferFunction};
    use cvr_core::volume::{Extent, SampleType, VolumeLayout};

    use super::*;
    use crate::Raycasting;

    fn view(alpha: f32) -> View {
        let point = |value, alpha| ControlPoint { value, rgba: [1.0, 0.5, 0.25, alpha] };
        View {
            size: [32, 32],
            camera: Camera::default(),
            transfer_function: Arc::new(
                TransferFunction::new(vec![point(0.0, alpha), point(1.0, alpha)]).unwrap(),
            ),
            step_voxels: 0.5,
            termination: 1.0,
            filter: Filter::Linear,
        }
    }

    /// Transparent at 0, half opaque at 1.
    fn ramp() -> Arc<TransferFunction> {
        let point = |value, alpha| ControlPoint { value, rgba: [1.0, 1.0, 1.0, alpha] };
        Arc::new(TransferFunction::new(vec![point(0.0, 0.0), point(1.0, 0.5)]).unwrap())
    }

    fn volume(edge: u32, value: impl Fn(usize) -> f32) -> DecodedFrame {
        let layout = VolumeLayout::scalar(Extent::cube(edge).unwrap(), SampleType::F32);
        let values = (0..edge.pow(3) as usize).map(value).collect();
        DecodedFrame::new(layout, values).unwrap()
    }

    fn draw(view: &View, voxels: &DecodedFrame) -> Image {
        let mut image = Image::new(view.size);
        Raycasting.reference(view, voxels, &mut image).unwrap();
        image
    }

    /// Through a homogeneous volume, opacity is that of the path's length, whatever the step.
    #[test]
    fn opacity_is_that_of_the_length_at_any_step() {
        let voxels = volume(16, |_| 0.5);
        for step_voxels in [0.25, 0.5, 1.0, 3.0] {
            let camera = Camera {
                azimuth: 0.0,
                elevation: 0.0,
                projection: Projection::Orthographic,
                ..Camera::default()
            };
            let image = draw(&View { step_voxels, camera, ..view(0.05) }, &voxels);
            let alpha = image.pixels()[16 * 32 + 16][3];
            let expected = 1.0 - 0.95_f32.powi(16);
            assert!((alpha - expected).abs() < 1e-4, "step {step_voxels}: {alpha} for {expected}");
        }
    }

    #[test]
    fn early_termination_changes_no_pixel_by_more_than_it_promises() {
        let voxels = volume(24, |i| (i % 7) as f32 / 7.0);
        let whole = draw(&view(0.3), &voxels);
        for termination in [0.5, 0.9, 0.99] {
            let cut = draw(&View { termination, ..view(0.3) }, &voxels);
            let difference = whole.pixels().iter().flatten().zip(cut.pixels().iter().flatten());
            let largest = difference.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(largest > 0.0 && largest <= 1.0 - termination + 1e-6, "{termination}: {largest}");
        }
    }

    /// An opacity a hair below the threshold goes on to the next sample, one a hair above does not: nobody may see it.
    #[test]
    fn the_end_of_a_ray_does_not_jump() {
        let voxels = volume(16, |_| 0.5);
        let camera = Camera {
            azimuth: 0.0,
            elevation: 0.0,
            projection: Projection::Orthographic,
            ..Camera::default()
        };
        let until = |termination: f32| {
            let view = View { termination, camera, step_voxels: 1.0, ..view(0.5) };
            draw(&view, &voxels).pixels()[16 * 32 + 16]
        };
        // Two samples of opacity 0.5 make 0.75.
        let (below, above) = (until(0.75 - 1e-6), until(0.75 + 1e-6));
        assert!(below.iter().zip(&above).all(|(a, b)| (a - b).abs() < 1e-5), "{below:?} {above:?}");
    }

    /// Along an axis every sample may lie on a face between two voxels; the least rounding must not choose.
    #[test]
    fn samples_on_voxel_faces_do_not_depend_on_rounding() {
        let voxels = volume(16, |i| ((i + i / 16 + i / 256) % 2) as f32);
        let camera = Camera {
            azimuth: 0.0,
            elevation: 0.0,
            projection: Projection::Orthographic,
            ..Camera::default()
        };
        let nearest = View { camera, filter: Filter::Nearest, transfer_function: ramp(), ..view(0.0) };
        let with = |step_voxels| draw(&View { step_voxels, ..nearest.clone() }, &voxels);
        let exact = with(2.0);
        for step_voxels in [2.0 - 1e-6, 2.0 + 1e-6] {
            let other = with(step_voxels);
            let pairs = exact.pixels().iter().flatten().zip(other.pixels().iter().flatten());
            let largest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(largest < 1e-3, "step {step_voxels}: {largest}");
        }
    }

    /// A slab bright at low x must appear on the left at azimuth 0, and one bright at high z at the top.
    #[test]
    fn the_picture_is_not_mirrored() {
        let camera = Camera { azimuth: 0.0, elevation: 0.0, ..Camera::default() };
        let view = View { camera, transfer_function: ramp(), ..view(0.0) };
        let mass = |image: &Image, keep: fn(usize, usize) -> bool| -> f32 {
            image.pixels().iter().enumerate().filter(|(i, _)| keep(i % 32, i / 32)).map(|(_, p)| p[3]).sum()
        };
        let left = draw(&view, &volume(16, |i| if i % 16 < 8 { 1.0 } else { 0.0 }));
        assert!(mass(&left, |x, _| x < 15) > 10.0 * mass(&left, |x, _| x > 16));
        let top = draw(&view, &volume(16, |i| if i / 256 >= 8 { 1.0 } else { 0.0 }));
        assert!(mass(&top, |_, y| y < 15) > 10.0 * mass(&top, |_, y| y > 16));
    }

    #[test]
    fn a_filter_that_decodes_cells_gives_the_linear_picture() {
        let voxels = volume(9, |i| (i * 31 % 17) as f32 / 17.0);
        let linear = View { transfer_function: ramp(), ..view(0.0) };
        let with = |filter| draw(&View { filter, ..linear.clone() }, &voxels);
        assert!(with(Filter::Linear) == with(Filter::OptimisedLinear));
        assert!(with(Filter::Linear) != with(Filter::Nearest));
    }
}
