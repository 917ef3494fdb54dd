//! Volumes whose values are hard rather than their shapes: offsets, magnitudes, no numbers, names.

use super::Subject;
use super::field::{hash, share, volume};
use crate::volume::{DenseVolume, SampleType};

pub(super) const SUBJECTS: &[Subject] = &[
    Subject::field(
        "offset",
        "a bump of 16 on an offset that dwarfs it",
        "offset ÷ height of the bump",
        &[0.0, 1e2, 1e4, 1e5, 1e6],
        offset,
    ),
    Subject::field(
        "dynamic-range",
        "a field over many orders of magnitude",
        "decades between the lowest and the highest value",
        &[1.0, 2.0, 4.0, 8.0, 16.0],
        dynamic_range,
    ),
    Subject::field(
        "non-finite",
        "a bump with NaN, infinities and subnormals in it, which are replaced before anything is encoded",
        "share of such samples",
        &[0.0, 0.001, 0.01, 0.1, 0.5],
        non_finite,
    ),
    Subject {
        labels: true,
        ..Subject::field(
            "labels",
            "names of regions, between which there is nothing",
            "number of names",
            &[2.0, 4.0, 16.0, 64.0, 250.0],
            labels,
        )
    },
];

fn offset(ratio: f64, edge: u32) -> DenseVolume {
    volume([edge; 3], 1, SampleType::F32, |at| 16.0 * (ratio + at.bump()))
}

/// Powers of two with straight lines between them: an exponential that is the same on every machine.
fn exp2(exponent: f64) -> f64 {
    let whole = exponent.floor();
    let biased = 1023 + whole.clamp(-1000.0, 1000.0) as i64;
    f64::from_bits((biased as u64) << 52) * (1.0 + exponent - whole)
}

fn dynamic_range(decades: f64, edge: u32) -> DenseVolume {
    let binary = decades * std::f64::consts::LOG2_10;
    volume([edge; 3], 1, SampleType::F32, |at| exp2(binary * (at.bump() - 1.0)))
}

fn non_finite(wanted: f64, edge: u32) -> DenseVolume {
    volume([edge; 3], 1, SampleType::F32, |at| {
        if at.noise(2) >= wanted {
            return 1.0 + 100.0 * at.bump();
        }
        let [x, y, z] = at.p;
        match hash([3, x, y, z]) % 4 {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::NEG_INFINITY,
            _ => 1e-40,
        }
    })
}

/// Regions around centres that chance has placed; names follow no order of places.
fn labels(names: f64, edge: u32) -> DenseVolume {
    let names = names as u32;
    let centre = |i: u32| [0, 1, 2].map(|axis| share([4, i, axis]) * f64::from(edge));
    let centres: Vec<[f64; 3]> = (0..names).map(centre).collect();
    volume([edge; 3], 1, SampleType::U8, |at| {
        let distance = |c: &[f64; 3]| -> f64 {
            (0..3).map(|a| (f64::from(at.p[a]) + 0.5 - c[a]) * (f64::from(at.p[a]) + 0.5 - c[a])).sum()
        };
        let nearest = centres.iter().map(distance).enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        // 251 is prime, so that names stay apart.
        nearest.map_or(0.0, |(i, _)| ((i * 97 + 13) % 251) as f64)
    })
}
