//! `shaders/skipping`: which samples may be left out.

use glam::Vec3;

use super::{Mirror, Ray};
use crate::render::Macrocells;

impl Mirror<'_> {
    /// Whether the macrocell of a point may show anything. Always true without skipping.
    #[must_use]
    pub fn may_show(&self, x: Vec3) -> bool {
        let Some(macrocells) = self.view.skippable(self.voxels.layout()) else { return true };
        macrocells.shows(macrocell_at(macrocells, x).as_uvec3().to_array())
    }

    /// The first sample, from number `first` on, that may show anything. Samples lie one step apart on the ray from
    /// `entry` to `end`. `next_sample` of the shaders.
    #[must_use]
    pub fn next_sample(&self, first: u32, entry: &Ray, end: f32) -> u32 {
        let Some(macrocells) = self.view.skippable(self.voxels.layout()) else { return first };
        let step = self.view.step_voxels;
        let mut i = first;
        while (i as f32) * step < end {
            let start = i as f32 * step;
            let x = entry.origin + entry.direction * (start + 0.5 * step.min(end - start));
            if self.may_show(x) {
                break;
            }
            let forward = Vec3::select(entry.direction.cmpge(Vec3::ZERO), Vec3::ONE, Vec3::ZERO);
            let face = (macrocell_at(macrocells, x) + forward) * Macrocells::EDGE as f32;
            let away = ((face - x).abs() + BEYOND) / entry.direction.abs().max(Vec3::splat(SLOWEST));
            i += 1 + (away.min_element() / step).min(MOST_AT_ONCE) as u32;
        }
        i
    }
}

/// Samples are skipped up to this many voxels beyond the face of an empty macrocell. A filter reads half a voxel
/// further and stays within the apron. The margin also prevents that a ray along a face tests it at every sample.
const BEYOND: f32 = 0.25;
/// Smallest speed of a ray along an axis, in voxels per voxel length. It prevents division by zero. A slower ray skips
/// fewer samples.
const SLOWEST: f32 = 1e-9;
/// Most samples skipped at once. Single precision still counts this number.
const MOST_AT_ONCE: f32 = 16_777_216.0;

/// The macrocell that holds a point. A point that rounding moved outside the volume counts as inside.
fn macrocell_at(macrocells: &Macrocells, x: Vec3) -> Vec3 {
    let last = Vec3::from_array(macrocells.grid().to_array().map(|n| n as f32 - 1.0));
    (x / Macrocells::EDGE as f32).floor().clamp(Vec3::ZERO, last)
}
