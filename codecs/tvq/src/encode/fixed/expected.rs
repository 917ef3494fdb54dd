//! The expected error of codebooks of the payload `fixed`, for any sizes, from training curves.

use cvr_core::codec::EncodeError;

use crate::encode::domain::Domain;
use crate::encode::sample::Sample;
use crate::encode::train::curves::{Curve, Curves};
use crate::encode::train::trainer::Trainer;
use crate::encode::tuned::codebooks::FIRST_ERROR;
use crate::encode::tuned::fixed::{CURVE_BLOCKS, CURVE_WIDTHS, ENOUGH_FOR, MOST_TRAINING};
use crate::encode::work::Work;

/// Training curves, and values derived from them.
#[derive(Debug)]
pub struct Expected {
    curves: Curves,
    /// Widths at which they were measured.
    measured: Vec<u32>,
}

/// Logarithms of the fraction of the error that a codebook leaves: alone, and behind others that left `before`.
#[derive(Copy, Clone, Debug)]
pub struct Left {
    pub alone: f64,
    pub behind: f64,
    pub before: f64,
}

impl Left {
    /// The logarithm of the fraction left behind codebooks that have left `before`. The more earlier codewords have
    /// removed, the less structure is left for later ones.
    pub fn after(&self, before: f64) -> f64 {
        let way = if self.before < 0.0 { (before / self.before).min(1.0) } else { 1.0 };
        before + self.alone + (self.behind - self.alone) * way
    }
}

impl Expected {
    /// Measures curves on some blocks of all domains.
    ///
    /// # Errors
    /// Those of reading, and when the run was cancelled.
    pub fn measure(work: &Work<'_>, domains: &[Domain]) -> Result<Self, EncodeError> {
        let seed = work.options.training.seed;
        let sample = Sample::draw(work.source, domains, work.quantiser, CURVE_BLOCKS, seed, work.run)?;
        let trainer = Trainer::new(&sample, work.training(true));
        let expected = FIRST_ERROR * work.span / work.unit();
        let most = (sample.len() / 3).max(1).ilog2();
        let measured: Vec<u32> = CURVE_WIDTHS.into_iter().filter(|w| *w <= most).collect();
        let threshold = work.threshold(expected);
        let curves = Curves::measure(&trainer, &measured, (work.mean_shift(expected), threshold), work.run)?;
        Ok(Self { curves, measured })
    }

    /// The logarithm of the fraction of the error that `size` codewords leave on a curve, interpolated and
    /// extrapolated. Training blocks have less error left than others, and more so with fewer blocks per codeword.
    /// Infinitely many blocks would leave an error about halfway between both. The distance of both is measured too.
    fn on(&self, work: &Work<'_>, curve: &Curve, size: usize) -> f64 {
        if size == 1 {
            return 0.0;
        }
        let measured = || self.measured.iter().map(|w| f64::from(*w)).zip(&curve.left);
        let middle =
            along(measured().map(|(w, [own, other])| (w, 0.5 * (own + other))), (size as f64).log2());
        let apart = measured().map(|(w, [own, other])| (w.exp2() / self.curves.trained, 0.5 * (other - own)));
        let blocks = work.blocks() / work.tables();
        let training = training_blocks(work, size).min(blocks);
        let apart = along(apart, size as f64 / training).max(0.0);
        let share = training / blocks;
        middle + (share * (-apart).exp() + (1.0 - share) * apart.exp()).ln()
    }

    /// The fraction that `size` codewords leave in a partition, alone and behind others.
    pub fn left(&self, work: &Work<'_>, partition: usize, size: usize) -> Left {
        let (first, curve) = (&self.curves.of[0], &self.curves.of[partition]);
        let behind = self.on(work, curve, size);
        // As the first, any codebook behaves like the first one, unless it is confined to zones.
        let alone = if work.options.confined { behind } else { self.on(work, first, size) };
        Left { alone, behind, before: curve.before }
    }

    /// The expected error (root mean square, in units of sums) of codebooks of these sizes.
    pub fn of(&self, work: &Work<'_>, books: [usize; 3]) -> f64 {
        let left = [0, 1, 2].map(|p| self.left(work, p, books[p]));
        (self.curves.mean_square * left.into_iter().fold(0.0, |before, left| left.after(before)).exp())
            .sqrt()
            .max(0.5)
    }
}

/// Number of training blocks of a table whose largest codebook has `size` codewords.
pub fn training_blocks(work: &Work<'_>, size: usize) -> f64 {
    (work.options.training.training_blocks as f64 * (size as f64 / ENOUGH_FOR).clamp(1.0, MOST_TRAINING))
        .floor()
}

/// The value at `x` of the line through the origin and some points, which are ordered by place. Straight beyond the
/// last.
fn along(points: impl Iterator<Item = (f64, f64)>, x: f64) -> f64 {
    let points: Vec<(f64, f64)> = std::iter::once((0.0, 0.0)).chain(points).collect();
    let after = points.iter().position(|p| p.0 >= x).unwrap_or(points.len() - 1).max(1);
    let (Some(a), Some(b)) = (points.get(after - 1), points.get(after)) else { return 0.0 };
    a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_points_goes_on_beyond_them() {
        let points = [(2.0, 4.0), (4.0, 5.0)];
        let at = |x| along(points.into_iter(), x);
        assert_eq!([0.0, 1.0, 2.0, 3.0, 6.0].map(at), [0.0, 2.0, 4.0, 4.5, 6.0]);
        assert_eq!(along(std::iter::empty(), 3.0), 0.0);
    }

    #[test]
    fn codebooks_do_less_behind_others() {
        let left = Left { alone: -1.0, behind: -0.5, before: -2.0 };
        assert_eq!(
            [0.0, -1.0, -2.0, -3.0].map(|before| left.after(before) - before),
            [-1.0, -0.75, -0.5, -0.5]
        );
    }
}
