//! Trials on few blocks: the result of codebooks for an error at which a bit pays, and the best such error for a width.

use cvr_core::codec::EncodeError;

use super::cost::{fixed_bits, groups, mean_bits};
use super::growth::Growth;
use super::measured::{Found, Measured};
use super::point::Point;
use crate::encode::closed_loop::Plane;
use crate::encode::train::book::Book;
use crate::encode::train::trainer::Trainer;
use crate::encode::tuned::growth::{EIGHTHS, LARGE};
use crate::encode::tuned::trials::{ABOUT_AS_GOOD, AS_GOOD, LEAST_ERROR, NEAR, STEEP};
use crate::encode::work::Work;
use cvr_groups::Expected;
use cvr_groups::{Aim, Settled, Sum, settle, settle_all};

/// Trials on few blocks.
pub struct Overview<'a, 'w> {
    pub work: &'a Work<'w>,
    pub trainer: Trainer<'a>,
    /// Means of all blocks in units of sums, by domain and plane.
    pub means: &'a [Vec<Plane>],
    /// What coding blocks directly leaves.
    pub expected: Expected,
    /// Errors in units of sums.
    pub aim: Aim,
    /// Whether codebooks are chosen one by one, by the quantity that the aim leaves free. Only if that takes little
    /// time.
    pub by_aim: bool,
}

/// A trial with its result. Prices and errors are in units of sums.
#[derive(Clone, Debug)]
pub struct Trial {
    pub point: Point,
    pub settled: Settled,
    /// Codewords of each codebook, if they were chosen one by one.
    pub sizes: Vec<usize>,
}

/// Bits and errors that do not depend on the price of codes.
struct Beside {
    width: u32,
    /// Bits of all means.
    means: f64,
    /// Number of blocks that each measured block represents.
    scale: f64,
}

impl Overview<'_, '_> {
    /// Bits of all means.
    fn mean_bits(&self, shift: u32) -> f64 {
        let domains = self.work.domains().zip(self.means);
        domains
            .map(|(domain, planes)| planes.iter().map(|p| mean_bits(p, domain.size, shift)).sum::<f64>())
            .sum()
    }

    /// Bits of everything and squared error, if `count` codebooks with `codewords` codewords are kept. `found` is the
    /// result of `blocks` measured blocks.
    fn sum(&self, beside: &Beside, (count, codewords): (usize, usize), found: Found, blocks: usize) -> Sum {
        // Blocks with codes lie together: about half the groups that could hold one each do.
        let planes = f64::from(2 * 32 * (usize::BITS - count.leading_zeros()));
        let planes = groups(self.work) * planes * (2.0 * found.open as f64 / blocks.max(1) as f64).min(1.0);
        let codes = (found.codes as f64 * f64::from(beside.width) + found.direct_bits) * beside.scale;
        let fixed = fixed_bits(self.work, count as u32, codewords as f64 * self.work.tables());
        Sum { bits: beside.means + fixed + codes + planes, error: found.error * beside.scale }
    }

    /// The result of codebooks for a point, with the aim met as well as possible.
    pub fn trial(&self, point: Point) -> Result<Trial, EncodeError> {
        let work = self.work;
        let shift = work.mean_shift(point.of_means());
        let code_price = point.price() * f64::from(point.width);
        let mut growth =
            Growth::new(&self.trainer, code_price, (shift, work.threshold(point.error)), true, self.expected);
        let beside = Beside { width: point.width, means: self.mean_bits(shift), scale: growth.scale() };
        if self.by_aim {
            return self.one_by_one(point, &mut growth, &beside);
        }
        let errors = growth.at_price(1 << point.width, point.price(), work.run)?;
        let codewords = counted(growth.books());
        let measured = Measured::of(&errors, point.width, self.expected);
        let sums = |price: f64| {
            let found = measured.at(price).into_iter().enumerate();
            found.map(|(m, found)| self.sum(&beside, (m, codewords[m]), found, measured.blocks())).collect()
        };
        Ok(Trial { point, settled: settle(self.aim, point.price(), sums), sizes: Vec::new() })
    }

    /// Adds codebooks while another one meets the aim better. Each has the best size: full, or a fraction.
    fn one_by_one(
        &self,
        mut point: Point,
        growth: &mut Growth<'_, '_>,
        beside: &Beside,
    ) -> Result<Trial, EncodeError> {
        let settled = |errors: &[Vec<f64>], codewords: usize, width: u32| {
            let beside = Beside { width, ..*beside };
            let (count, measured) = (errors.len() - 1, Measured::of(errors, width, self.expected));
            let at =
                |price: f64| self.sum(&beside, (count, codewords), measured.all_at(price), measured.blocks());
            settle_all(self.aim, count, point.price(), at)
        };
        let mut errors = vec![growth.errors()];
        let mut best = settled(&errors, 0, point.width);
        let (mut full, mut width) = (1_usize << point.width, point.width);
        let mut sizes = Vec::new();
        while let Some(open) = growth.open() {
            let codewords: usize = sizes.iter().sum();
            let mut found = None;
            for part in EIGHTHS {
                let size = full.min(open.most) * part / 8;
                if size < 2 {
                    break;
                }
                if (codewords + size) as f64 * self.trainer.codeword_bits() > self.aim.most_bits() {
                    continue;
                }
                let candidate = growth.candidate(&open, size, self.work.run)?;
                errors.push(growth.errors_with(&candidate));
                // The first codebook is the largest. All codes have its width.
                let width = if sizes.is_empty() { candidate.book.width() } else { width };
                let now = settled(&errors, codewords + candidate.book.size(), width);
                errors.pop();
                if self.aim.order(now.sum, best.sum).is_ge() {
                    if found.is_some() {
                        break;
                    }
                    continue;
                }
                best = now;
                found = Some(candidate);
                if full < LARGE {
                    break;
                }
            }
            let Some(candidate) = found else { break };
            if sizes.is_empty() {
                width = candidate.book.width();
            }
            full = candidate.book.size().next_power_of_two();
            sizes.push(candidate.book.size());
            errors.push(growth.errors_with(&candidate));
            growth.push(candidate);
        }
        point.width = width;
        Ok(Trial { point, settled: best, sizes })
    }

    /// The error at which a bit pays that meets the aim best, for codes of one width, in at most `most` trials. Of
    /// about equally good errors, the one whose assumed value of a bit is correct.
    pub fn find(&self, mut point: Point, most: usize) -> Result<Trial, EncodeError> {
        let mut trials: Vec<Trial> = Vec::new();
        // Logarithm of the error at which a bit pays, and its deviation, which decreases.
        let mut known: Vec<(f64, f64)> = Vec::new();
        for _ in 0..most {
            let trial = self.trial(point)?;
            let off = point.off(trial.settled.price);
            trials.push(trial);
            if off.abs() < NEAR {
                break;
            }
            known.push((point.error.ln(), off.clamp(-STEEP, STEEP)));
            let next = near_zero(&known).unwrap_or(point.error.ln() + off);
            let next = next.clamp(LEAST_ERROR.ln(), 12.0);
            if (next - point.error.ln()).abs() < NEAR {
                break;
            }
            point.error = next.exp();
        }
        let off = |t: &Trial| t.point.off(t.settled.price).abs();
        let mut good = self.good(trials);
        let order = |a: &Trial, b: &Trial| self.aim.order(a.settled.sum, b.settled.sum);
        let near = |a: &Trial, b: &Trial| off(a).total_cmp(&off(b));
        good.sort_by(|a, b| if self.by_aim { order(a, b) } else { near(a, b).then(order(a, b)) });
        good.into_iter().next().ok_or(EncodeError::Unsupported("no trial".to_owned()))
    }

    /// The trials that are about as good as the best. Unused bits have no value, and neither has less error than the
    /// target.
    pub fn good(&self, mut trials: Vec<Trial>) -> Vec<Trial> {
        let aim = self.aim;
        let factor = if self.by_aim { AS_GOOD } else { ABOUT_AS_GOOD };
        let best = trials.iter().map(|t| t.settled.sum).min_by(|a, b| aim.order(*a, *b)).unwrap_or_default();
        trials.retain(|t| {
            let [is, least] = [t.settled.sum, best].map(|s| aim.left(s));
            aim.met(t.settled.sum) == aim.met(best) && is <= factor * least
        });
        trials
    }
}

/// By count of codebooks, from none to all, their codewords.
fn counted(books: &[Book]) -> Vec<usize> {
    (0..=books.len()).map(|m| books.iter().take(m).map(Book::size).sum()).collect()
}

/// The zero, interpolated between the two nearest known points on either side, if there are two. Each is a place and a
/// value; values decrease.
fn near_zero(known: &[(f64, f64)]) -> Option<f64> {
    let before = known.iter().filter(|k| k.1 > 0.0).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let after = known.iter().filter(|k| k.1 <= 0.0).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(before.0 + (after.0 - before.0) * before.1 / (before.1 - after.1))
}
