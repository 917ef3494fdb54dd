//! The raycaster on the CPU: `raycasting.wgsl`, function by function.

use cvr_core::render::mirror::{Mirror, Ray, opacity_over};
use cvr_core::render::{Image, RenderError, View, Voxels};

/// Draws every pixel.
pub fn draw(view: &View, voxels: &dyn Voxels, image: &mut Image) -> Result<(), RenderError> {
    let mirror = Mirror::new(view, voxels);
    mirror.draw(image, |pixel| cast_ray(&mirror, mirror.pixel_ray(pixel)))
}

/// Premultiplied colour and opacity along a ray. No loop ends early here.
fn cast_ray(mirror: &Mirror<'_>, ray: Ray) -> Result<[f32; 4], RenderError> {
    let View { step_voxels: step, termination, .. } = *mirror.view();
    let inside = mirror.crossing(&ray);
    // Positions start where the ray enters. Smaller numbers have smaller rounding errors.
    let entry = Ray { origin: ray.origin + ray.direction * inside.near, ..ray };
    let end = inside.far - inside.near;

    let mut result = [0.0_f32; 4];
    let mut i = mirror.next_sample(0, &entry, end);
    // A sample stands for the piece of ray around it. The last piece is cut at the border, so that the picture does not
    // depend on the rounding of the division.
    while i as f32 * step < end {
        let start = i as f32 * step;
        let piece = step.min(end - start);
        let [r, g, b, a] =
            mirror.optical(entry.origin + entry.direction * (start + 0.5 * piece), entry.direction)?;
        if a > 0.0 {
            let weight = opacity_over(a, piece) * (1.0 - result[3]);
            // The last sample counts only up to the end of the ray. So the picture is the same whether the ray ends
            // here or, by rounding, one sample later.
            let rest = termination - result[3];
            for (sum, term) in result.iter_mut().zip([r, g, b, 1.0]) {
                *sum += term * weight.min(rest);
            }
            if weight >= rest {
                break;
            }
        }
        i = mirror.next_sample(i + 1, &entry, end);
    }
    Ok(result)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use cvr_core::render::{
        Camera, ControlPoint, DecodedFrame, Filter, Projection, Renderer, TransferFunction,
    };
    use cvr_core::volume::{Extent, SampleType, VolumeLayout};

    use super::*;
    use crate::Raycasting;

    fn view(alpha: f32) -> View {
        let point = |value, alpha| ControlPoint { value, rgba: [1.0, 0.5, 0.25, alpha] };
        let function = TransferFunction::new(vec![point(0.0, alpha), point(1.0, alpha)]).unwrap();
        View { size: [32, 32], ..View::new(function) }
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

    /// In a homogeneous volume, opacity depends on the length of the path, not on the step.
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

    /// An opacity slightly below the threshold goes on to the next sample; one slightly above does not. The difference
    /// must not be visible.
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

    /// Along an axis every sample may lie on a face between two voxels. Rounding must not choose the voxel.
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

    /// A layer that is bright at low x must appear on the left at azimuth 0, and one that is bright at high z at the
    /// top.
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
