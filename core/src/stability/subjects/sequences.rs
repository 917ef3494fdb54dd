//! Volumes over time: a step that moves, and a cut between two scenes.

use super::Subject;
use super::field::volume;
use crate::volume::{DenseVolume, FrameIndex, SampleType};

/// Frames of a sequence; the third is drawn, the first after the cut.
const FRAMES: u32 = 4;
const CUT: u32 = 2;

pub(super) const SUBJECTS: &[Subject] = &[
    Subject {
        frame: FrameIndex(CUT),
        ..Subject::field(
            "moving-step",
            "two materials with a plane between them that moves, in four frames",
            "voxels per frame",
            &[0.0, 1.0, 2.0, 3.0, 4.0],
            moving_step,
        )
    },
    Subject {
        frame: FrameIndex(CUT),
        ..Subject::field(
            "scene-cut",
            "four frames; the last two show something else",
            "share of the volume that changes at the cut",
            &[0.0, 0.25, 0.5, 0.75, 1.0],
            scene_cut,
        )
    },
];

fn moving_step(speed: f64, edge: u32) -> DenseVolume {
    let size = edge * 2 / 3;
    volume([size; 3], FRAMES, SampleType::U8, |at| {
        let border = (size / 4 + speed as u32 * at.frame).min(size - 1);
        20.0 * at.ramp() + if at.p[0] < border { 20.0 } else { 210.0 }
    })
}

fn scene_cut(share: f64, edge: u32) -> DenseVolume {
    let size = edge * 2 / 3;
    volume([size; 3], FRAMES, SampleType::U8, |at| {
        let changed = at.frame >= CUT && at.unit()[2] < share;
        let bump = at.bump();
        // Noise of the scene and not of the frame: what does not change is the same.
        let grain = 15.0 * super::field::share([6, u32::from(changed), at.p[0], at.p[1], at.p[2]]);
        grain + 240.0 * if changed { (1.0 - bump) * at.ramp() } else { bump }
    })
}
