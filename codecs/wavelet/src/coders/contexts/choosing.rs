//! Quantisation that weighs what a coefficient costs against the error that it leaves.

use std::ops::Range;

use super::adaptive::Adaptive;
use super::band::Side;
use super::binarisation::{write, write_bit};
use super::models::Models;
use crate::coders::fault::Fault;
use crate::coders::range::Encoder;

/// Squared error, in squares of the step, that one bit has to save. At high rates the slope of rate over distortion is
/// 2 ln 2 / 12 = 0.116. Of 0.09, 0.12, 0.15 and 0.19 the least was best on four volumes and three rates.
const PRICE: f32 = 0.1;

/// Magnitudes from here on are rounded: one less would save next to nothing.
const ROUNDED: u32 = 64;

/// Bits that a symbol of a probability costs.
#[derive(Debug)]
pub struct Costs(Vec<f32>);

impl Default for Costs {
    fn default() -> Self {
        Self((0..=4096_u16).map(|p| -(f32::from(p).max(0.5) / 4096.0).log2()).collect())
    }
}

impl Costs {
    #[inline]
    fn of(&self, model: Adaptive, bit: bool) -> f32 {
        let zero = usize::from(model.zero() >> 4);
        self.0[if bit { 4096 - zero } else { zero }]
    }

    /// Bits of a magnitude and its sign in surroundings of a class.
    #[inline]
    fn magnitude(&self, models: &Models, magnitude: u32, class: usize) -> f32 {
        if magnitude == 0 {
            return self.of(models.nonzero[class], false);
        }
        let below = magnitude.ilog2() as usize;
        let mut cost = self.of(models.nonzero[class], true) + 1.0;
        for longer in &models.longer[..below] {
            cost += self.of(longer[class], true);
        }
        cost += self.of(models.longer[below][class], false);
        if below > 0 {
            let second = magnitude >> (below - 1) & 1 == 1;
            cost += self.of(models.second[below][class], second) + (below - 1) as f32;
        }
        cost
    }
}

/// Chooses the coefficients of a part of a band, and writes them.
#[derive(Debug)]
pub struct Choosing<'a> {
    /// What takes the bits.
    pub encoder: &'a mut Encoder,
    /// What symbols cost.
    pub costs: &'a Costs,
    /// The coefficients of the transform.
    pub coefficients: &'a [f32],
    /// One over the step.
    pub scale: f32,
}

impl Choosing<'_> {
    /// The nearest magnitude, the one below, or 0: whichever costs least, error and bits together. The effect on the
    /// contexts of later coefficients is not counted.
    #[inline]
    fn choose(&self, models: &Models, value: f32, class: usize) -> i32 {
        let exact = value.abs().min((1 << 30) as f32);
        let near = (exact + 0.5) as u32;
        if near == 0 {
            return 0;
        }
        let mut best = near;
        if near < ROUNDED {
            let badness = |magnitude: u32| {
                let error = exact - magnitude as f32;
                error * error + PRICE * self.costs.magnitude(models, magnitude, class)
            };
            let mut least = badness(near);
            for other in [near - 1, 0].into_iter().take(if near == 2 { 2 } else { 1 }) {
                let found = badness(other);
                if found < least {
                    (least, best) = (found, other);
                }
            }
        }
        if value < 0.0 { -(best as i32) } else { best as i32 }
    }
}

impl Side for Choosing<'_> {
    /// A segment is left out if what its coefficients save is worth less than what it costs to write them.
    #[inline]
    fn segment(&mut self, models: &mut Models, places: Range<usize>) -> Result<bool, Fault> {
        let zero = self.costs.of(models.nonzero[0], false);
        let one = self.costs.of(models.nonzero[0], true) + 1.0 - zero;
        let flag = self.costs.of(models.segment, true) - self.costs.of(models.segment, false);
        let price = PRICE * (flag + zero * places.len() as f32);
        let saved = |coefficient: &f32| {
            let exact = coefficient.abs() * self.scale;
            let near = (exact + 0.5).floor();
            let error = exact - near;
            (exact * exact - error * error - PRICE * (one + 2.0 * (near - 1.0).max(0.0))).max(0.0)
        };
        let coefficients = &self.coefficients[places];
        let any = coefficients.iter().any(|c| c.abs() * self.scale >= 0.5);
        let any = any && coefficients.iter().map(saved).sum::<f32>() > price;
        write_bit(self.encoder, &mut models.segment, any);
        Ok(any)
    }

    #[inline]
    fn coefficient(
        &mut self,
        models: &mut Models,
        place: usize,
        class: usize,
        negative: impl Fn() -> (usize, usize),
    ) -> Result<i32, Fault> {
        let value = self.choose(models, self.coefficients[place] * self.scale, class);
        write(self.encoder, models, value, class, negative);
        Ok(value)
    }
}
