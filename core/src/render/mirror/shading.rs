//! `shaders/optics`: gradients, and the light on them.

use glam::Vec3;

use super::Mirror;
use crate::render::RenderError;
use crate::render::uniforms::LightingUniform;

impl Mirror<'_> {
    /// Change of the height (the value, or what of a colour decides) per voxel length along x, y, z of the world, by central differences one voxel apart.
    pub(super) fn gradient(&self, x: Vec3) -> Result<Vec3, RenderError> {
        let mut difference = Vec3::ZERO;
        for (axis, unit) in Vec3::AXES.into_iter().enumerate() {
            difference[axis] = self.height(x + unit)? - self.height(x - unit)?;
        }
        Ok(difference * 0.5 / self.rays.voxel_size)
    }
}

/// The colour that a surface across `gradient` shows, of a sample of colour `rgb`.
pub(super) fn blinn_phong(
    lighting: &LightingUniform,
    rgb: Vec3,
    gradient: Vec3,
    towards_viewer: Vec3,
) -> Vec3 {
    let normal = gradient / (gradient.dot(gradient) + lighting.flat * lighting.flat).sqrt();
    let between = lighting.towards_light + towards_viewer;
    let half = between / between.length().max(1e-6);
    let upright = normal.dot(lighting.towards_light).abs();
    let mirrored = normal.dot(half).abs().clamp(1e-4, 1.0);
    let highlight = lighting.specular * mirrored.powf(lighting.shininess);
    (rgb * (lighting.ambient + lighting.diffuse * upright) + highlight).min(Vec3::ONE)
}
