//! The 3-D Shepp–Logan head phantom with modified contrast.
//!
//! Semi-axes and centres are those of M. Schabel's `phantom3d` (after A. Kak and M. Slaney, "Principles of
//! Computerized Tomographic Imaging", 1988, section 3.2); densities are those of P. Toft, "The Radon
//! Transform", 1996, table B.3, whose larger contrast shows the soft tissue in 8 bits. The ventricles are
//! turned by ∓18° about the z axis through their own centres, so that the slice z = 0 is the phantom of 1974.

use cvr_core::volume::Extent;

use super::{Signal, signed_centre};

/// Density added inside, semi-axes, centre, sine and cosine of the rotation about z; lengths in −1..1.
struct Ellipsoid(f64, [f64; 3], [f64; 3], [f64; 2]);

const UPRIGHT: [f64; 2] = [0.0, 1.0];
// Written out, because a machine's own sine may differ in the last bit: so the phantom is the same everywhere.
const SIN_18_DEGREES: f64 = 0.309_016_994_374_947_4;
const COS_18_DEGREES: f64 = 0.951_056_516_295_153_5;
const TURNED_RIGHT: [f64; 2] = [-SIN_18_DEGREES, COS_18_DEGREES];
const TURNED_LEFT: [f64; 2] = [SIN_18_DEGREES, COS_18_DEGREES];

const ELLIPSOIDS: [Ellipsoid; 10] = [
    Ellipsoid(1.0, [0.6900, 0.920, 0.810], [0.0, 0.0, 0.0], UPRIGHT),
    Ellipsoid(-0.8, [0.6624, 0.874, 0.780], [0.0, -0.0184, 0.0], UPRIGHT),
    Ellipsoid(-0.2, [0.1100, 0.310, 0.220], [0.22, 0.0, 0.0], TURNED_RIGHT),
    Ellipsoid(-0.2, [0.1600, 0.410, 0.280], [-0.22, 0.0, 0.0], TURNED_LEFT),
    Ellipsoid(0.1, [0.2100, 0.250, 0.410], [0.0, 0.35, -0.15], UPRIGHT),
    Ellipsoid(0.1, [0.0460, 0.046, 0.050], [0.0, 0.1, 0.25], UPRIGHT),
    Ellipsoid(0.1, [0.0460, 0.046, 0.050], [0.0, -0.1, 0.25], UPRIGHT),
    Ellipsoid(0.1, [0.0460, 0.023, 0.050], [-0.08, -0.605, 0.0], UPRIGHT),
    Ellipsoid(0.1, [0.0230, 0.023, 0.020], [0.0, -0.606, 0.0], UPRIGHT),
    Ellipsoid(0.1, [0.0230, 0.046, 0.020], [0.06, -0.605, 0.0], UPRIGHT),
];

pub(super) struct SheppLogan {
    extent: Extent,
}

impl SheppLogan {
    pub const fn new(extent: Extent) -> Self {
        Self { extent }
    }
}

impl Signal for SheppLogan {
    fn fill_row(&self, y: u32, z: u32, row: &mut [f64]) {
        row.fill(0.0);
        let y = signed_centre(y, self.extent.y());
        let z = signed_centre(z, self.extent.z());
        for Ellipsoid(density, [a, b, c], [cx, cy, cz], [sin, cos]) in &ELLIPSOIDS {
            let dy = y - cy;
            let w = ((z - cz) / c).powi(2);
            if w > 1.0 {
                continue; // The whole slice misses it.
            }
            for (v, i) in row.iter_mut().zip(0..) {
                let dx = signed_centre(i, self.extent.x()) - cx;
                let u = (cos * dx + sin * dy) / a;
                let t = (cos * dy - sin * dx) / b;
                if u * u + t * t + w <= 1.0 {
                    *v += density;
                }
            }
        }
        // Densities are decimal fractions: their sums miss 0 by a rounding error.
        for v in row {
            *v = v.clamp(0.0, 1.0);
        }
    }
}
