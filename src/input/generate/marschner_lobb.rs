//! The test signal of S. Marschner and R. Lobb, "An evaluation of reconstruction filters for volume
//! rendering", IEEE Visualization 1994, section 4.
//!
//! With `x, y, z` in −1..1 and `ρ(r) = cos(2π fM cos(πr/2))`,
//! `signal = (1 − sin(πz/2) + α (1 + ρ(√(x² + y²)))) / (2 (1 + α))`.

use std::f64::consts::{FRAC_PI_2, TAU};

use cvr_core::volume::Extent;

use super::{Signal, signed_centre};

/// Highest frequency of the ripple, in periods per unit of length.
const FM: f64 = 6.0;
/// Amplitude of the ripple against the slow wave along z.
const ALPHA: f64 = 0.25;

pub(super) struct MarschnerLobb {
    extent: Extent,
}

impl MarschnerLobb {
    pub const fn new(extent: Extent) -> Self {
        Self { extent }
    }
}

impl Signal for MarschnerLobb {
    fn fill_row(&self, y: u32, z: u32, row: &mut [f64]) {
        let y = signed_centre(y, self.extent.y());
        let slow = 1.0 - (FRAC_PI_2 * signed_centre(z, self.extent.z())).sin();
        for (v, i) in row.iter_mut().zip(0..) {
            let x = signed_centre(i, self.extent.x());
            let ripple = (TAU * FM * (FRAC_PI_2 * (x * x + y * y).sqrt()).cos()).cos();
            *v = (slow + ALPHA * (1.0 + ripple)) / (2.0 * (1.0 + ALPHA));
        }
    }
}
