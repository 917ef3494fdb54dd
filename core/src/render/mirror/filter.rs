//! `shaders/filter`: values between voxel centres.

use std::ops::{Add, Mul, Sub};

use glam::{IVec3, Vec3};

use super::Mirror;
use crate::render::{Filter, RenderError};

impl Mirror<'_> {
    /// `volume_sample` of a scalar volume.
    pub(super) fn scalar_sample(&self, x: Vec3) -> Result<f32, RenderError> {
        self.volume_sample(x, |[value, ..]| value)
    }

    /// `volume_sample` of a colour volume.
    pub(super) fn colour_sample(&self, x: Vec3) -> Result<Vec3, RenderError> {
        self.volume_sample(x, |[r, g, b, _]| Vec3::new(r, g, b))
    }

    fn volume_sample<V>(&self, x: Vec3, voxel_of: fn([f32; 4]) -> V) -> Result<V, RenderError>
    where
        V: Copy + Add<Output = V> + Sub<Output = V> + Mul<f32, Output = V>,
    {
        let last = IVec3::from_array(self.voxels.layout().extent.to_array().map(|e| e as i32 - 1));
        let clamped = |p: IVec3| p.clamp(IVec3::ZERO, last).as_uvec3().to_array();
        if self.view.filter == Filter::Nearest {
            let below = x.floor();
            let up = (x - below).cmpge(Vec3::splat(1.0 - Filter::NEAREST_TIE));
            let voxel = Vec3::select(up, below + 1.0, below);
            return Ok(voxel_of(self.voxels.fetch(clamped(voxel.as_ivec3()))?));
        }
        let base = (x - 0.5).floor();
        let t = (x - 0.5) - base;
        let p = base.as_ivec3();
        let cell = self.voxels.fetch_cell(clamped(p), clamped(p + 1))?;
        Ok(trilinear(cell.map(voxel_of), t))
    }
}

/// Interpolates along x, then y, then z.
pub(in crate::render) fn trilinear<V>(c: [V; 8], t: Vec3) -> V
where
    V: Copy + Add<Output = V> + Sub<Output = V> + Mul<f32, Output = V>,
{
    let c00 = c[0] + (c[1] - c[0]) * t.x;
    let c10 = c[2] + (c[3] - c[2]) * t.x;
    let c01 = c[4] + (c[5] - c[4]) * t.x;
    let c11 = c[6] + (c[7] - c[6]) * t.x;
    let c0 = c00 + (c10 - c00) * t.y;
    let c1 = c01 + (c11 - c01) * t.y;
    c0 + (c1 - c0) * t.z
}
