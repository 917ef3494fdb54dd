//! The uniforms that all renderers' shaders share, with the fields that the templates declare.

use encase::internal::WriteInto;
use encase::{ShaderSize, ShaderType, UniformBuffer};
use glam::{UVec2, Vec3, Vec4};

use super::colour::light_range;
use super::{Projection, RayFrame, RenderError, Shading, View};
use crate::volume::SampleType;

/// `View` of `shaders/view/view.wgsl`.
#[derive(Clone, Debug, PartialEq, ShaderType)]
pub(super) struct ViewUniform {
    origin: Vec3,
    step: f32,
    direction: Vec3,
    termination: f32,
    right: Vec3,
    pixel: f32,
    up: Vec3,
    voxel_size: Vec3,
    size: UVec2,
    transfer_keys: [Vec4; 2],
}

impl ViewUniform {
    pub(super) fn new(view: &View, rays: &RayFrame) -> Self {
        let (right, up) = match view.camera.projection {
            Projection::Perspective => (rays.direction_right, rays.direction_up),
            Projection::Orthographic => (rays.origin_right, rays.origin_up),
        };
        Self {
            origin: rays.origin,
            step: view.step_voxels,
            direction: rays.direction,
            termination: view.termination,
            right,
            pixel: rays.pixel,
            up,
            voxel_size: rays.voxel_size,
            size: UVec2::from_array(view.size),
            transfer_keys: view.transfer_function.search_keys().map(Vec4::from_array),
        }
    }
}

/// `Lighting` of `shaders/optics/lit.wgsl`. The mirror computes with the same numbers.
#[derive(Copy, Clone, Debug, PartialEq, ShaderType)]
pub(super) struct LightingUniform {
    /// Unit vector towards the light, in world coordinates.
    pub(super) towards_light: Vec3,
    pub(super) ambient: f32,
    pub(super) diffuse: f32,
    pub(super) specular: f32,
    pub(super) shininess: f32,
    /// Gradients far below this value count as none, in data units per voxel length.
    pub(super) flat: f32,
}

impl LightingUniform {
    pub(super) fn new(view: &View, shading: &Shading, rays: &RayFrame) -> Self {
        Self {
            towards_light: shading.towards_light(rays),
            ambient: shading.ambient,
            diffuse: shading.diffuse,
            specular: shading.specular,
            shininess: shading.shininess,
            // Shaders divide by it.
            flat: ((view.transfer_function.domain().span() * f64::from(Shading::FLAT)) as f32)
                .max(f32::MIN_POSITIVE),
        }
    }
}

/// `Colour` of `shaders/classify/colour.wgsl`. The mirror computes with the same numbers.
#[derive(Copy, Clone, Debug, PartialEq, ShaderType)]
pub(super) struct ColourUniform {
    pub(super) weights: Vec3,
    pub(super) scale: f32,
    pub(super) offset: f32,
}

impl ColourUniform {
    pub(super) fn new(view: &View, sample: SampleType) -> Self {
        let range = light_range(sample, view.value_range);
        let span = if range.span() > 0.0 { range.span() } else { 1.0 };
        Self { weights: view.colour_opacity.weights(), scale: (1.0 / span) as f32, offset: range.min }
    }

    /// `light` of the shader.
    pub(super) fn light(&self, voxel: Vec3) -> Vec3 {
        ((voxel - self.offset) * self.scale).clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// `Clip` of `shaders/bounds/clip.wgsl`, in voxel coordinates.
#[derive(Copy, Clone, Debug, PartialEq, ShaderType)]
pub(super) struct ClipUniform {
    low: Vec3,
    high: Vec3,
}

impl ClipUniform {
    pub(super) const fn new([low, high]: [Vec3; 2]) -> Self {
        Self { low, high }
    }
}

/// The bytes of a uniform, in WGSL's layout.
///
/// # Errors
/// When the layout cannot hold them.
pub fn uniform_bytes<T: ShaderType + ShaderSize + WriteInto>(value: &T) -> Result<Vec<u8>, RenderError> {
    let mut bytes = UniformBuffer::new(Vec::new());
    bytes.write(value).map_err(|e| RenderError::Unsupported(e.to_string()))?;
    Ok(bytes.into_inner())
}
