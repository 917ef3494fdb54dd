//! The pass that draws a view.

use cvr_core::render::{ComputePass, Pass, Plan, Projection, RenderError, View};
use cvr_core::shader::BindingKind;
use cvr_core::volume::VolumeLayout;
use cvr_shaders as shaders;
use encase::{ShaderType, UniformBuffer};
use glam::{UVec2, Vec3};

/// Threads per workgroup along x and y, as `raycasting.wgsl` declares them.
const WORKGROUP: u32 = 8;

/// The uniform of `raycasting.wgsl`, field by field.
#[derive(ShaderType)]
struct Uniform {
    origin: Vec3,
    step: f32,
    direction: Vec3,
    termination: f32,
    right: Vec3,
    pixel: f32,
    up: Vec3,
    transfer_offset: f32,
    voxel_size: Vec3,
    transfer_scale: f32,
    size: UVec2,
}

pub fn plan(view: &View, layout: &VolumeLayout) -> Result<Plan, RenderError> {
    let rays = view.camera.rays(layout, view.size);
    let (camera, right, up) = match view.camera.projection {
        Projection::Perspective => (shaders::CAMERA_PERSPECTIVE, rays.direction_right, rays.direction_up),
        Projection::Orthographic => (shaders::CAMERA_ORTHOGRAPHIC, rays.origin_right, rays.origin_up),
    };
    let uniform = Uniform {
        origin: rays.origin,
        step: view.step_voxels,
        direction: rays.direction,
        termination: view.termination,
        right,
        pixel: rays.pixel,
        up,
        transfer_offset: view.transfer_function.domain().min,
        voxel_size: rays.voxel_size,
        transfer_scale: view.transfer_function.scale(),
        size: UVec2::from_array(view.size),
    };
    let mut bytes = UniformBuffer::new(Vec::new());
    bytes.write(&uniform).map_err(|e| RenderError::Unsupported(e.to_string()))?;
    let pass = ComputePass {
        templates: vec![shaders::RAYCASTING, camera, shaders::CLASSIFY_SCALAR, shaders::OPACITY],
        entry: "raycast",
        bindings: &[BindingKind::View, BindingKind::TransferTable, BindingKind::Image],
        view: bytes.into_inner(),
        workgroups: [view.size[0].div_ceil(WORKGROUP), view.size[1].div_ceil(WORKGROUP), 1],
    };
    Ok(Plan {
        size: view.size,
        passes: vec![Pass::Compute(pass)],
        transfer_table: view.transfer_function.table().to_vec(),
    })
}
