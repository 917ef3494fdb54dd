//! Coefficients as multiples of steps.

use super::lift::norms;
use super::scale::Scale;
use super::shape::{Coefficients, KIND, for_places, levels};
use super::{Filter, Options};

/// A coefficient counts from this fraction of a step on, in 256ths: dead zone. Tuned on bonsai and lidc_chest.
const ROUNDING: i64 = 120;
/// The same for blocks with a wider dead zone: 1.5 % of a step wider. Derived: more than steps that count as alike differ.
const WIDER: i64 = 116;
/// What a bit costs more in them. Derived: as for the dead zone.
const DEARER: f64 = 1.02;
/// Squared error, in squares of a step, that a bit must save. Tuned on bonsai and lidc_chest.
pub const BIT_PRICE: f64 = 0.12;

/// Steps of all coefficients, and how they are chosen from.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantiser {
    pub edge: usize,
    pub filter: Filter,
    pub scale: Scale,
    pub low_step: i32,
    /// Steps of each level and kind, the coarsest level first.
    pub steps: Vec<[i32; 3]>,
    /// Squared error, in squares of a step, that a bit must save. A place of coefficients of −1, 0 and 1 that are not worth
    /// their bits loses them.
    pub price: f64,
    /// Share of the blocks, in 2^-32, that have a wider dead zone. Where many coefficients are equal, they all lie on one
    /// side of the dead zone, and bits jump from step to step. This share is what they jump by.
    pub wider: u32,
}

impl Quantiser {
    /// Steps that keep everything.
    pub fn exact(options: &Options, scale: Scale) -> Self {
        let edge = options.block as usize;
        let steps = vec![[1; 3]; levels(edge)];
        Self { edge, filter: options.filter, scale, low_step: 1, steps, price: 0.0, wider: 0 }
    }

    /// The steps of one error: each coefficient's is `step`, in integers of the transform, over how strongly it shows.
    /// So an error of a step is the same in all, if the transform were orthonormal.
    pub fn of_step(options: &Options, scale: Scale, step: f64, price: f64) -> Self {
        let edge = options.block as usize;
        let of = |norm: f64| (step / norm).round().clamp(1.0, f64::from(1 << 28)) as i32;
        let steps = (0..levels(edge)).map(|level| {
            let [low, high] = norms(options.filter, edge, levels(edge) - level);
            [1, 2, 3].map(|kind| of(low.powi(3 - kind) * high.powi(kind)))
        });
        let steps = steps.collect();
        let [low, _] = norms(options.filter, edge, levels(edge));
        Self { edge, filter: options.filter, scale, low_step: of(low.powi(3)), steps, price, wider: 0 }
    }

    /// Quantises a transformed block. `number` differs from block to block.
    pub fn quantise(&self, block: &[i32], number: u32, out: &mut Coefficients) {
        let is_wider = number.wrapping_mul(0x9e37_79b9) < self.wider;
        let (rounding, price) = if is_wider { (WIDER, self.price * DEARER) } else { (ROUNDING, self.price) };
        out.high.clear();
        out.high.resize(Coefficients::places(self.edge), [0; 7]);
        // The mean shows over the whole block: it is rounded to nearest.
        out.low = rounded(block[0], self.low_step, 128);
        for_places(self.edge, |number, level, at| {
            let place = &mut out.high[number];
            let steps = &self.steps[level];
            let mut most = 0;
            for ((q, at), kind) in place.iter_mut().zip(at).zip(KIND) {
                *q = rounded(block[at], steps[kind], rounding);
                most = most.max(q.unsigned_abs());
            }
            // Steps of 1 lose nothing.
            let may_drop = most == 1 && price > 0.0 && steps[0] > 1;
            if may_drop && value_of_bits(place, |slot| block[at[slot]], steps) <= price {
                *place = [0; 7];
            }
        });
    }

    /// The transformed block of quantised coefficients.
    pub fn restore(&self, coefficients: &Coefficients, block: &mut [i32]) {
        block[0] = coefficients.low.wrapping_mul(self.low_step);
        for_places(self.edge, |number, level, at| {
            for ((at, q), kind) in at.into_iter().zip(coefficients.high[number]).zip(KIND) {
                block[at] = q.wrapping_mul(self.steps[level][kind]);
            }
        });
    }
}

/// A coefficient in steps. It counts upwards from `256 − rounding` 256ths of a step.
#[inline]
const fn rounded(c: i32, step: i32, rounding: i64) -> i32 {
    if step == 1 {
        return c;
    }
    let bias = ((step as i64 * rounding) >> 8) as u32;
    let q = ((c.unsigned_abs() + bias) / step as u32) as i32;
    if c < 0 { -q } else { q }
}

/// Squared error that each bit of coefficients of −1, 0 and 1 saves, in squares of a step.
fn value_of_bits(place: &[i32; 7], coefficient: impl Fn(usize) -> i32, steps: &[i32; 3]) -> f64 {
    let (mut saved, mut bits) = (0.0, 7.0);
    for (slot, _) in place.iter().enumerate().filter(|(_, q)| **q != 0) {
        let size = f64::from(coefficient(slot).unsigned_abs()) / f64::from(steps[KIND[slot]]);
        saved += 2.0 * size - 1.0;
        bits += 1.0;
    }
    saved / bits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coefficient_counts_from_the_dead_zone_on() {
        assert_eq!([59, 60, 61, 159, 160, -61, -59].map(|c| rounded(c, 100, 104)), [0, 1, 1, 1, 2, -1, 0]);
        assert_eq!(rounded(i32::MIN / 4, 1, 104), i32::MIN / 4);
    }
}
