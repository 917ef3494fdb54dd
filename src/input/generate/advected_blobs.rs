//! Smooth blobs that a vortex carries around the axis x = y = ½ while they rise and sink: a sequence whose frames
//! differ by motion alone.
//!
//! Every number is made of additions, multiplications and divisions in double precision, which IEEE 754 rounds the
//! same everywhere, and of a hash in integers; there is no sine. Frame `t` does not depend on how many frames there
//! are.
//!
//! Blob `i` has the profile `a (1 − d²/r²)²` at distance `d < r` of its centre (so that it is smooth at its border).
//! Per frame its centre turns by the angle whose half has the tangent `u`, so that cosine and sine are
//! `(1 − u²)/(1 + u²)` and `2u/(1 + u²)`, and moves along z, from one face to the other and back.

use cvr_core::volume::Extent;

use super::turbulence::mix;
use super::{Signal, centre};

const BLOBS: u64 = 16;

pub(super) struct AdvectedBlobs {
    extent: Extent,
    blobs: Vec<Blob>,
}

/// A blob at the time of one frame; lengths in the unit cube.
struct Blob {
    centre: [f64; 3],
    radius_squared: f64,
    amplitude: f64,
}

impl AdvectedBlobs {
    pub fn new(extent: Extent, seed: u64, frame: u32) -> Self {
        Self { extent, blobs: (0..BLOBS).map(|i| Blob::at(seed, i, frame)).collect() }
    }
}

impl Blob {
    fn at(seed: u64, index: u64, frame: u32) -> Self {
        // A number in 0..1 with 32 bits, for each property of the blob. The seed is mixed first: two seeds that differ
        // in their low bits alone would else have the same blobs in another order.
        let chance = |property: u64| {
            let hash = [index, property].into_iter().fold(mix(seed), |h, c| mix(h ^ c));
            (hash >> 32) as f64 / 4_294_967_296.0
        };
        let mut x = 0.7 * chance(0) - 0.35;
        let mut y = 0.7 * chance(1) - 0.35;
        let z = chance(2);
        let radius = 0.08 + 0.12 * chance(3);
        let amplitude = 0.4 + 0.6 * chance(4);
        // From 2 to 7 degrees per frame, all in one direction.
        let u = 0.0175 + 0.0435 * chance(5);
        let rise = 0.02 * chance(6) - 0.01;
        let (cos, sin) = ((1.0 - u * u) / (1.0 + u * u), 2.0 * u / (1.0 + u * u));
        for _ in 0..frame {
            (x, y) = (cos * x - sin * y, sin * x + cos * y);
        }
        Self {
            centre: [0.5 + x, 0.5 + y, reflected(z + f64::from(frame) * rise)],
            radius_squared: radius * radius,
            amplitude,
        }
    }
}

/// To and fro between 0 and 1.
fn reflected(z: f64) -> f64 {
    let turn = z - 2.0 * (z / 2.0).floor();
    if turn > 1.0 { 2.0 - turn } else { turn }
}

impl Signal for AdvectedBlobs {
    fn fill_row(&self, y: u32, z: u32, row: &mut [f64]) {
        row.fill(0.0);
        let (y, z) = (centre(y, self.extent.y()), centre(z, self.extent.z()));
        for Blob { centre: [cx, cy, cz], radius_squared, amplitude } in &self.blobs {
            let aside = (y - cy) * (y - cy) + (z - cz) * (z - cz);
            if aside >= *radius_squared {
                continue; // The whole row misses it.
            }
            for (v, i) in row.iter_mut().zip(0..) {
                let x = centre(i, self.extent.x());
                let rest = 1.0 - ((x - cx) * (x - cx) + aside) / radius_squared;
                if rest > 0.0 {
                    *v += amplitude * rest * rest;
                }
            }
        }
        for v in row {
            *v = v.min(1.0);
        }
    }
}
