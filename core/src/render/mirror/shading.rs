//! `shaders/optics`: gradients, and the light on them.

use glam::Vec3;

use super::Mirror;
use crate::render::RenderError;
use crate::render::uniforms::LightingUniform;

impl Mirror<'_> {
    /// Gradient of the height (the value, or for colours the number that the opacity depends on) per voxel length along
    /// x, y, z of the world, by central differences one voxel apart.
    pub(super) fn gradient(&self, x: Vec3) -> Result<Vec3, RenderError> {
        let mut difference = Vec3::ZERO;
        for (axis, unit) in Vec3::AXES.into_iter().enumerate() {
            difference[axis] = self.height(x + unit)? - self.height(x - unit)?;
        }
        Ok(difference * 0.5 / self.rays.voxel_size)
    }
}

/// The lit colour of a surface with normal `gradient`, for a sample of colour `rgb`.
pub(super) fn blinn_phong(
    lighting: &LightingUniform,
    rgb: Vec3,
    gradient: Vec3,
    towards_viewer: Vec3,
) -> Vec3 {
    let steepness = gradient / lighting.flat;
    let normal = steepness / (steepness.dot(steepness) + 1.0).sqrt();
    let between = lighting.towards_light + towards_viewer;
    let half = between / between.length().max(1e-6);
    let upright = normal.dot(lighting.towards_light).abs();
    let mirrored = normal.dot(half).abs().clamp(1e-4, 1.0);
    let highlight = lighting.specular * mirrored.powf(lighting.shininess);
    (rgb * (lighting.ambient + lighting.diffuse * upright) + highlight).min(Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{ControlPoint, Shading, TransferFunction, View};
    use crate::volume::{Extent, SampleType, VolumeLayout};

    /// The colour of a surface if all data are multiplied by `scale`.
    fn seen(scale: f32) -> Vec3 {
        let point = |value, alpha| ControlPoint { value, rgba: [1.0, 1.0, 1.0, alpha] };
        let view = View::new(TransferFunction::new(vec![point(0.0, 0.0), point(scale, 1.0)]).unwrap());
        let layout = VolumeLayout::scalar(Extent::cube(8).unwrap(), SampleType::F32);
        let rays = view.camera.rays(&layout, view.size);
        let lighting = LightingUniform::new(&view, &Shading::default(), &rays);
        blinn_phong(&lighting, Vec3::new(0.8, 0.6, 0.4), Vec3::new(0.1, -0.05, 0.2) * scale, Vec3::Z)
    }

    #[test]
    fn the_unit_of_the_data_does_not_change_the_light() {
        let expected = seen(1.0);
        assert!(expected.max_element() < 0.99 && expected.min_element() > 0.1, "{expected}");
        for scale in [1e-28, 1e-3, 255.0, 1e30] {
            let got = seen(scale);
            assert!(got.distance(expected) < 1e-5, "{scale}: {got} for {expected}");
        }
    }

    #[test]
    fn where_nothing_changes_there_is_only_ambient_light() {
        let view = View::new(
            TransferFunction::new(vec![
                ControlPoint { value: 0.0, rgba: [1.0; 4] },
                ControlPoint { value: 1.0, rgba: [1.0; 4] },
            ])
            .unwrap(),
        );
        let layout = VolumeLayout::scalar(Extent::cube(8).unwrap(), SampleType::F32);
        let rays = view.camera.rays(&layout, view.size);
        let lighting = LightingUniform::new(&view, &Shading::default(), &rays);
        let got = blinn_phong(&lighting, Vec3::ONE, Vec3::ZERO, Vec3::Z);
        assert!(got.distance(Vec3::splat(lighting.ambient)) < 1e-6, "{got}");
    }
}
