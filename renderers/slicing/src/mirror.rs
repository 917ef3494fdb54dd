//! The slices on the CPU: `slicing.wgsl` and its modules, function by function. It sums in single precision.

use cvr_core::render::mirror::{Mirror, Ray, opacity_over};
use cvr_core::render::{Image, RenderError, View, Voxels};

use crate::slabs::Slabs;
use crate::{OpacityCorrection, Slicing};

/// Draws every pixel.
pub fn draw(
    slicing: &Slicing,
    view: &View,
    voxels: &dyn Voxels,
    image: &mut Image,
) -> Result<(), RenderError> {
    let mirror = Mirror::new(view, voxels);
    let slabs = Slabs::new(slicing.geometry, view, voxels.layout(), mirror.rays())?;
    mirror.draw(image, |pixel| {
        let ray = mirror.pixel_ray(pixel);
        let inside = mirror.crossing(&ray);
        let end = inside.far - inside.near;
        let mut result = [0.0_f32; 4];
        if end > 0.0 {
            let entry = Ray { origin: ray.origin + ray.direction * inside.near, ..ray };
            for slice in slabs.crossed(&entry, inside.near, end).rev() {
                if let Some(fragment) = fragment(slicing, &mirror, &slabs, &entry, [inside.near, end], slice)?
                {
                    let behind = 1.0 - fragment[3];
                    for (sum, term) in result.iter_mut().zip(fragment) {
                        *sum = term + *sum * behind;
                    }
                }
            }
        }
        Ok(result)
    })
}

/// The result of the shader's `slice`. `None` if it discards.
fn fragment(
    slicing: &Slicing,
    mirror: &Mirror<'_>,
    slabs: &Slabs,
    entry: &Ray,
    [travelled, end]: [f32; 2],
    slice: u32,
) -> Result<Option<[f32; 4]>, RenderError> {
    let slab = slabs.crossing(entry, travelled, slice);
    let near = slab.near.max(0.0);
    let piece = slab.far.min(end) - near;
    if piece <= 0.0 {
        return Ok(None);
    }
    let x = entry.origin + entry.direction * (near + 0.5 * piece);
    if !mirror.may_show(x) {
        return Ok(None);
    }
    let [r, g, b, a] = mirror.optical(x, entry.direction)?;
    let opacity = slice_opacity(slicing.opacity_correction, a, piece, slabs.thickness);
    Ok(Some([r * opacity, g * opacity, b * opacity, opacity]))
}

/// Opacity of a piece of ray within a slab, from the opacity per voxel length.
pub fn slice_opacity(correction: OpacityCorrection, alpha: f32, piece: f32, thickness: f32) -> f32 {
    match correction {
        OpacityCorrection::Exact => opacity_over(alpha, piece),
        OpacityCorrection::Lerp => {
            let opacity = opacity_over(alpha, thickness);
            let beyond = piece / thickness - 1.0;
            if beyond <= 0.0 {
                return opacity * (beyond + 1.0);
            }
            let t = beyond * (1.0 + (1.0 - beyond) * (0.18365 - 0.0385 * beyond));
            (opacity + (opacity - opacity * opacity) * t).min(1.0)
        }
    }
}
