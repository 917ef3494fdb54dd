//! Slicing: a stack of slices, blended back to front by the hardware, with a CPU mirror.
//!
//! Three geometries (Guthe and Straßer 2001, section 4.1): *planes*, perpendicular to the view; *axis*, planes across
//! the axis of the volume that is closest to the view direction, as in stacks of textures; *shells*, parts of spheres
//! around the eye. A slice stands for the slab around it. Along a ray, a slice adds the opacity of the *piece of that
//! ray* within its slab. So brightness depends neither on the angle nor on the axis of the stack.
//!
//! Slices of the geometry *axis* can also be drawn from a ring of four decoded layers, for the site *ring*.
//!
//! `shaders/slicing` and `mirror` use the same arithmetic in the same order. The mirror sums in single precision.
//! Slices cannot end a ray early, so this renderer ignores `early_termination`.

mod layers;
mod mirror;
pub mod modules;
mod plan;
mod proxies;
mod slabs;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use cvr_core::codec::{ConfigError, Setting, SettingKind, Settings};
use cvr_core::render::{Blending, Image, Plan, RenderError, Renderer, RendererInfo, View, Voxels};
use cvr_core::volume::VolumeLayout;

const INFO: RendererInfo = RendererInfo {
    id: "slicing",
    summary: "slices back to front, blended by the hardware; planes, axis stacks or shells",
    settings: &[
        Setting {
            name: "geometry",
            doc: "planes upright to the view, stacks across the volume's main axis, or shells around the eye",
            kind: SettingKind::Choice(&["planes", "axis", "shells"]),
            default: "planes",
        },
        Setting {
            name: "opacity_correction",
            doc: "opacity of a slice for the way of the ray through it: by the power, or interpolated between two powers",
            kind: SettingKind::Choice(&["exact", "lerp"]),
            default: "exact",
        },
        Setting {
            name: "blending",
            doc: "precision of the blended sums",
            kind: SettingKind::Choice(&["float32", "float16"]),
            default: "float32",
        },
    ],
    layers: Some(&[("geometry", "axis")]),
};

/// Where slices lie.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum Geometry {
    /// Planes upright to the view.
    #[default]
    Planes,
    /// Planes across the volume's axis that is nearest to the view.
    Axis,
    /// Spheres around the eye. For parallel rays, whose eye is infinitely far away, planes.
    Shells,
}

/// How a slice's opacity follows from the length of the ray in its slab.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum OpacityCorrection {
    /// 1 − (1 − α)^d.
    #[default]
    Exact,
    /// Interpolated between the opacities of one and of two slice distances, as in the paper, which tabulates the
    /// weight of least relative error. The paper's equation 2 uses transparencies, its text opacities. The two give
    /// different weights. This is the text's: it is within 3 % of the exact opacity, the other within 9 %.
    Lerp,
}

/// The renderer `slicing`.
#[derive(Copy, Clone, Debug, Default)]
pub struct Slicing {
    /// Where slices lie.
    pub geometry: Geometry,
    /// Opacity of a slice.
    pub opacity_correction: OpacityCorrection,
    /// Precision of the blended sums.
    pub blending: Blending,
}

impl Renderer for Slicing {
    fn info(&self) -> &'static RendererInfo {
        &INFO
    }

    fn with(&self, settings: &Settings) -> Result<Arc<dyn Renderer>, ConfigError> {
        let geometry = match settings.text("geometry")? {
            "axis" => Geometry::Axis,
            "shells" => Geometry::Shells,
            _ => Geometry::Planes,
        };
        let opacity_correction = match settings.text("opacity_correction")? {
            "lerp" => OpacityCorrection::Lerp,
            _ => OpacityCorrection::Exact,
        };
        let blending = match settings.text("blending")? {
            "float16" => Blending::Float16,
            _ => Blending::Float32,
        };
        Ok(Arc::new(Self { geometry, opacity_correction, blending }))
    }

    fn plan(&self, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
        plan::plan(self, view, layout)
    }

    fn plan_layers(&self, view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
        layers::plan(self, view, layout)
    }

    fn reference(&self, view: &View, voxels: &dyn Voxels, image: &mut Image) -> Result<(), RenderError> {
        mirror::draw(self, view, voxels, image)
    }
}
