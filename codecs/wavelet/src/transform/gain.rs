//! Gains of a filter along one axis: how large coefficients can be, and how much an error in one weighs.

use super::filter::{Filter, Half, Kernel};

/// Gains of the coefficients of one band along one axis.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Gain {
    /// Euclidean norm of the samples that a coefficient of 1 becomes, away from the ends of the line.
    pub synthesis: f64,
    /// Sum of the magnitudes of the weights of the samples in a coefficient.
    pub analysis: f64,
}

/// The factor between samples and low coefficients after `decompositions` of an axis of `n` samples.
#[must_use]
pub fn low(filter: Filter, n: usize, decompositions: usize) -> f64 {
    let real = (0..decompositions).filter(|done| n.div_ceil(1 << (*done).min(63)) > 1).count();
    filter.low_gain().powi(real as i32)
}

/// Gains of the low or high band after `decompositions` of an axis of `n` samples, the last of which made the band.
/// Decompositions that find a line of one sample leave it as it is.
#[must_use]
pub fn of_band(filter: Filter, n: usize, decompositions: usize, high: bool) -> Gain {
    let real = (0..decompositions).filter(|done| n.div_ceil(1 << (*done).min(63)) > 1).count();
    if real == 0 {
        return Gain { synthesis: 1.0, analysis: 1.0 };
    }
    let norm = |line: &[f64]| line.iter().map(|v| v * v).sum::<f64>().sqrt();
    let synthesis = norm(&spread(filter, real, high, false));
    let analysis = spread(filter, real, high, true).iter().map(|v| v.abs()).sum();
    Gain { synthesis, analysis }
}

/// The samples that one coefficient of 1 becomes. `dual`: the weights of the samples in it instead, which are what it
/// becomes under the transposed filters.
fn spread(filter: Filter, decompositions: usize, high: bool, dual: bool) -> Vec<f64> {
    // Every filter has at most 6 coefficients around it at each level.
    let coarse = 32;
    let mut low = vec![0.0; coarse];
    let mut own = vec![0.0; coarse];
    own[coarse / 2] = 1.0;
    for done in 0..decompositions {
        let empty = vec![0.0; low.len()];
        let (s, d) = match (done, high) {
            (0, true) => (empty, own.clone()),
            (0, false) => (own.clone(), empty),
            _ => (low.clone(), empty),
        };
        low = synthesise(filter, s, d, dual);
    }
    low
}

/// One synthesis of a periodic line, or the transposed analysis.
fn synthesise(filter: Filter, mut s: Vec<f64>, mut d: Vec<f64>, dual: bool) -> Vec<f64> {
    let half = s.len() as isize;
    let at = |i: isize| i.rem_euclid(half) as usize;
    // The reversible filter is linear but for its rounding.
    const FIVE_THREE: [super::Step; 2] = [
        super::Step { to: Half::Odd, first: 0, taps: &[-0.5, -0.5] },
        super::Step { to: Half::Even, first: -1, taps: &[0.25, 0.25] },
    ];
    let steps = match filter.kernel() {
        Kernel::Lifting(steps) => steps,
        Kernel::Integer => &FIVE_THREE[..],
        Kernel::Orthonormal(taps) => {
            let (n, factor) = (taps.len(), if dual { 1.0 } else { 2.0 });
            let mut out = vec![0.0; 2 * s.len()];
            for i in 0..s.len() {
                for k in 0..n {
                    let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                    out[(2 * i + k) % (2 * s.len())] +=
                        factor * (taps[k] * s[i] + sign * taps[n - 1 - k] * d[i]);
                }
            }
            return out;
        }
    };
    for step in steps.iter().rev() {
        // The inverse of a step subtracts what it added. Its transpose adds in the other direction.
        let to_even = (step.to == Half::Even) != dual;
        let (to, from) = if to_even { (&mut s, &d) } else { (&mut d, &s) };
        for i in 0..half {
            for (k, tap) in step.taps.iter().enumerate() {
                let shift = step.first + k as isize;
                if dual {
                    to[at(i + shift)] += tap * from[i as usize];
                } else {
                    to[i as usize] -= tap * from[at(i + shift)];
                }
            }
        }
    }
    s.into_iter().zip(d).flat_map(|(s, d)| [s, d]).collect()
}
