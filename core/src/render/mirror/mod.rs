//! The shared shader modules on the CPU: same functions, same names, same order of operations, in single precision. The
//! mirrors of the renderers use it. Together they define the golden images.

mod filter;
mod rays;
mod shading;
mod skipping;

use glam::Vec3;
use rayon::prelude::*;

pub(super) use filter::trilinear;
pub use rays::{Crossing, Ray};

use super::uniforms::{ColourUniform, LightingUniform};
use super::{ColourOpacity, Image, RayFrame, RenderError, View, Voxels};

/// A view of a volume, with the values that its shader would read.
pub struct Mirror<'a> {
    view: &'a View,
    voxels: &'a dyn Voxels,
    rays: RayFrame,
    bounds: [Vec3; 2],
    lighting: Option<LightingUniform>,
    /// Of a colour volume.
    colour: Option<ColourUniform>,
}

impl std::fmt::Debug for Mirror<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Mirror").field("view", self.view).finish_non_exhaustive()
    }
}

impl<'a> Mirror<'a> {
    /// Prepares the values that all pixels share.
    #[must_use]
    pub fn new(view: &'a View, voxels: &'a dyn Voxels) -> Self {
        let layout = voxels.layout();
        let rays = view.rays(layout);
        let lighting = view.shading.as_ref().map(|shading| LightingUniform::new(view, shading, &rays));
        let colour = (layout.channels != 1).then(|| ColourUniform::new(view, layout.sample));
        Self { view, voxels, rays, bounds: view.bounds(layout.extent), lighting, colour }
    }

    /// The view.
    #[must_use]
    pub const fn view(&self) -> &'a View {
        self.view
    }

    /// The rays of the picture.
    #[must_use]
    pub const fn rays(&self) -> &RayFrame {
        &self.rays
    }

    /// Fills an image, rows in parallel. `colour` returns the premultiplied RGBA of a pixel.
    ///
    /// # Errors
    /// The first that `colour` meets.
    ///
    /// # Panics
    /// When `image` has another size than the view.
    pub fn draw(
        &self,
        image: &mut Image,
        colour: impl Fn([u32; 2]) -> Result<[f32; 4], RenderError> + Sync,
    ) -> Result<(), RenderError> {
        assert_eq!(image.size(), self.view.size, "picture of another size than the view");
        let width = self.view.size[0] as usize;
        image.pixels_mut().par_chunks_mut(width).enumerate().try_for_each(|(y, row)| {
            row.iter_mut().zip(0..).try_for_each(|(pixel, x): (_, u32)| {
                *pixel = colour([x, y as u32])?;
                Ok(())
            })
        })
    }

    /// Colour and opacity per voxel length at a point, for a ray's direction: `optical` of `shaders/optics`.
    ///
    /// # Errors
    /// When a voxel cannot be read.
    pub fn optical(&self, x: Vec3, direction: Vec3) -> Result<[f32; 4], RenderError> {
        let colour = self.classify(x)?;
        match &self.lighting {
            Some(lighting) if colour[3] > 0.0 => {
                let [r, g, b, a] = colour;
                let towards_viewer = -direction * self.rays.voxel_size;
                let lit =
                    shading::blinn_phong(lighting, Vec3::new(r, g, b), self.gradient(x)?, towards_viewer);
                Ok([lit.x, lit.y, lit.z, a])
            }
            _ => Ok(colour),
        }
    }

    /// `classify(volume_sample(x))` of the shaders.
    fn classify(&self, x: Vec3) -> Result<[f32; 4], RenderError> {
        let Some(colour) = &self.colour else {
            return Ok(self.view.transfer_function.classify(self.scalar_sample(x)?));
        };
        let voxel = self.colour_sample(x)?;
        let light = colour.light(voxel);
        if let ColourOpacity::Table(table) = &self.view.colour_opacity {
            return Ok([light.x, light.y, light.z, table.opacity(light)]);
        }
        let [r, g, b, a] = self.view.transfer_function.classify(colour.weights.dot(voxel));
        Ok([r * light.x, g * light.y, b * light.z, a])
    }

    /// `height(volume_sample(x))` of the shaders.
    fn height(&self, x: Vec3) -> Result<f32, RenderError> {
        match &self.colour {
            None => self.scalar_sample(x),
            Some(colour) => Ok(colour.weights.dot(self.colour_sample(x)?)),
        }
    }
}

/// Opacity of a piece of ray, `length` voxels long, from the opacity per voxel length: `shaders/classify/opacity.wgsl`.
#[must_use]
pub fn opacity_over(alpha: f32, length: f32) -> f32 {
    1.0 - transparency(alpha).powf(length)
}

/// 1 − α per voxel length. α stays below 1, else a power of zero would hide later differences.
#[must_use]
pub fn transparency(alpha: f32) -> f32 {
    1.0 - alpha.min(0.99999)
}
