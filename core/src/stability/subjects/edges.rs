//! Volumes of edges: a step, one hot voxel, a thin sheet, a checkerboard, a sharp front.

use super::Subject;
use super::field::{At, volume};
use crate::volume::{DenseVolume, SampleType};

pub(super) const SUBJECTS: &[Subject] = &[
    Subject::field(
        "step",
        "two materials with a plane between them, at every phase against grids of blocks",
        "phase, in voxels beyond a multiple of 16",
        &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0],
        step,
    ),
    Subject::field(
        "hot-voxel",
        "one voxel that stands out of a gentle ramp",
        "its value, over 20 to 40 around it",
        &[60.0, 100.0, 150.0, 200.0, 255.0],
        hot_voxel,
    ),
    Subject::field(
        "sheet",
        "a sheet one voxel thick, tilted more and more",
        "tilt, in voxels of rise per voxel",
        &[0.0, 0.125, 0.25, 0.5, 1.0],
        sheet,
    ),
    Subject::field(
        "checkerboard",
        "fields of two values in turn along all axes",
        "edge of a field, in voxels",
        &[16.0, 8.0, 4.0, 2.0, 1.0],
        checkerboard,
    ),
    Subject::field(
        "front",
        "a part of a thin, ragged, saturated shell in a smooth volume, as in flames: few blocks hold most of the contrast",
        "share of blocks of 4³ that the front crosses",
        &[0.001, 0.003, 0.01, 0.03, 0.1],
        front,
    ),
];

/// The gentle ramp of materials, `0.0..=20.0`.
fn shade(at: &At) -> f64 {
    20.0 * at.ramp()
}

fn step(phase: f64, edge: u32) -> DenseVolume {
    // The multiple of 16 next to the middle from below, so that phases stay inside.
    let border = (edge / 2 / 16 * 16 + phase as u32).clamp(1, edge - 1);
    volume([edge; 3], 1, SampleType::U8, |at| shade(at) + if at.p[0] < border { 20.0 } else { 210.0 })
}

fn hot_voxel(value: f64, edge: u32) -> DenseVolume {
    let hot = [edge / 2, edge / 2 + 1, edge / 2 - 1];
    volume([edge; 3], 1, SampleType::U8, |at| if at.p == hot { value } else { 20.0 + shade(at) })
}

fn sheet(tilt: f64, edge: u32) -> DenseVolume {
    let middle = f64::from(edge) / 2.0;
    volume([edge; 3], 1, SampleType::U8, |at| {
        let [x, y, z] = at.p.map(|c| f64::from(c) - middle);
        let away = z - 0.5 - tilt * (x + 0.5 * y);
        shade(at) + if (-0.5..0.5).contains(&away) { 220.0 } else { 20.0 }
    })
}

fn front(share_of_blocks: f64, edge: u32) -> DenseVolume {
    let (middle, radius) = (f64::from(edge) * 0.5 + 0.3, f64::from(edge) * 0.36);
    let away = |p: [f64; 3]| p.map(|c| (c - middle).powi(2)).iter().sum::<f64>().sqrt() - radius;
    // Blocks whose centre is near the shell, those of one side first: the front is a cap that grows.
    let along = edge.div_ceil(4);
    let centre = |n: u32| [n % along, n / along % along, n / along / along].map(|b| f64::from(4 * b) + 1.5);
    let mut crossed: Vec<u32> = (0..along.pow(3)).filter(|n| away(centre(*n)).abs() < 2.0).collect();
    let place = |n: &u32| {
        let [x, y, z] = centre(*n);
        x + 2.0 * y + 3.0 * z
    };
    crossed.sort_by(|a, b| place(a).total_cmp(&place(b)));
    crossed.truncate((share_of_blocks * f64::from(along.pow(3))).round() as usize);
    crossed.sort_unstable();
    volume([edge; 3], 1, SampleType::U8, |at| {
        let [x, y, z] = at.p.map(|c| c / 4);
        let smooth = 20.0 + 40.0 * at.bump();
        let on_front = crossed.binary_search(&((z * along + y) * along + x)).is_ok();
        let distance = away(at.p.map(f64::from)).abs();
        if on_front && distance < 0.5 + at.noise(17) {
            (140.0 + 200.0 * at.noise(18)).min(255.0)
        } else {
            smooth
        }
    })
}

fn checkerboard(field: f64, edge: u32) -> DenseVolume {
    let fields = |p: u32| p / field as u32;
    volume([edge; 3], 1, SampleType::U8, |at| {
        let odd = at.p.map(fields).iter().sum::<u32>() % 2 == 1;
        if odd { 220.0 } else { 30.0 }
    })
}
