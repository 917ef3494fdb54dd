//! Volumes whose sizes are hard: no multiples of a block, and slabs.

use super::Subject;
use super::field::{At, volume};
use crate::volume::{DenseVolume, SampleType};

pub(super) const SUBJECTS: &[Subject] = &[
    Subject::field(
        "odd-sizes",
        "a bump with a little noise, of sizes that no block divides",
        "voxels cut off each axis",
        &[0.0, 1.0, 2.0, 3.0, 5.0, 7.0],
        odd_sizes,
    ),
    Subject::field(
        "slab",
        "the same bump, thinner and thinner",
        "thickness, in voxels",
        &[12.0, 8.0, 4.0, 2.0, 1.0],
        slab,
    ),
];

fn grainy(at: &At) -> f64 {
    240.0 * at.bump() + 15.0 * at.noise(5)
}

fn odd_sizes(cut: f64, edge: u32) -> DenseVolume {
    volume([edge - cut as u32; 3], 1, SampleType::U8, grainy)
}

fn slab(thickness: f64, edge: u32) -> DenseVolume {
    volume([edge, edge, thickness as u32], 1, SampleType::U8, grainy)
}
