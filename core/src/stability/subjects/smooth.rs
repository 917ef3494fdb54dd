//! Smooth volumes: nothing, a ramp, waves, and noise on a bump.

use super::Subject;
use super::field::volume;
use crate::volume::{DenseVolume, SampleType};

pub(super) const SUBJECTS: &[Subject] = &[
    Subject::field(
        "constant",
        "one value everywhere",
        "the value, in data units",
        &[0.0, 1.0, 0.1, 1e-20, 1e30],
        constant,
    ),
    Subject::field(
        "ramp",
        "a ramp across the volume, bent more and more",
        "power of the ramp",
        &[1.0, 2.0, 4.0, 8.0, 16.0],
        ramp,
    ),
    Subject::field(
        "sinusoid",
        "waves along all axes, up to Nyquist's limit",
        "voxels per period",
        &[24.0, 12.0, 6.0, 3.0, 2.0],
        sinusoid,
    ),
    Subject::field(
        "noise",
        "white noise on a smooth bump",
        "noise as a share of the range",
        &[0.0, 0.015_625, 0.0625, 0.25, 1.0],
        noise,
    ),
];

fn constant(value: f64, edge: u32) -> DenseVolume {
    volume([edge; 3], 1, SampleType::F32, |_| value)
}

fn ramp(power: f64, edge: u32) -> DenseVolume {
    // Products one by one: what `powi` rounds to is the machine's.
    let bent = |t: f64| (0..power as u32).fold(1.0, |product, _| product * t);
    volume([edge; 3], 1, SampleType::U16, |at| 65535.0 * bent(at.ramp()))
}

fn sinusoid(period: f64, edge: u32) -> DenseVolume {
    let wave = |p: u32| (std::f64::consts::TAU * f64::from(p) / period).cos();
    volume([edge; 3], 1, SampleType::U16, |at| {
        let [x, y, z] = at.p.map(wave);
        32768.0 + 10_000.0 * (x + y + z)
    })
}

fn noise(share: f64, edge: u32) -> DenseVolume {
    volume([edge; 3], 1, SampleType::U8, |at| 255.0 * ((1.0 - share) * at.bump() + share * at.noise(1)))
}
