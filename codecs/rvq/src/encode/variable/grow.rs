//! Codebooks at a price of a bit: one after the other, each on the blocks for which another code may pay.

use cvr_codebook::settings::TrainingSettings;
use cvr_codebook::{Search, Vectors};
use cvr_core::codec::{Cancelled, Progress};
use cvr_groups::Expected;

use super::means::Means;
use crate::encode::stage::{Stage, subtract};
use crate::stream::Entries;

/// Another code is tried where more than this part of its price is left of a block.
const OPEN: f64 = 1.5;
/// Training blocks for each codeword, at least.
const FEWEST_BLOCKS: f64 = 6.0;
/// And at most: further ones change little. Limit.
const MOST_BLOCKS: usize = 256;
/// An escape of a block has a cost: its error and the price of its bits. A block trains no codebook if this cost is below this part
/// of the block's error.
const DIRECT: f64 = 0.25;
/// A codebook that does not pay is halved so often before the list ends.
const HALVINGS: u32 = 1;

/// Training blocks in units of sums, and what they stand for.
#[derive(Debug)]
pub struct Sample {
    /// Blocks.
    pub vectors: Vectors,
    /// Blocks of the volume for a weight of one.
    pub scale: f64,
}

/// What codebooks are grown for.
#[derive(Copy, Clone, Debug)]
pub struct Wanted {
    /// Codewords of a codebook, at most.
    pub size: usize,
    /// Codebooks, at most.
    pub stages: u32,
    /// Squared error that a bit is worth, in units of sums.
    pub price: f64,
    /// How means are rounded.
    pub means: Means,
    /// How the values of a codeword are stored.
    pub entries: Entries,
    /// What coding a block directly is expected to come to.
    pub expected: Expected,
    /// Whether blocks that are cheap to code directly train codebooks all the same.
    pub all_train: bool,
}

impl Wanted {
    /// Bits of a code.
    #[must_use]
    pub fn width(&self) -> u32 {
        cvr_codebook::index_bits(self.size)
    }

    /// Whether a block trains a codebook. `error` is what the codes so far leave of it.
    #[must_use]
    pub fn trains(&self, error: f64) -> bool {
        let direct = || self.expected.direct(error, self.price);
        self.all_train || direct().is_none_or(|direct| direct.cost > DIRECT * error)
    }

    /// Bits of a codeword.
    #[must_use]
    pub const fn codeword_bits(&self) -> f64 {
        let voxel = match self.entries {
            Entries::Colours => 32,
            Entries::Bits8 | Entries::Bits16 => self.entries.code_bits() * self.means.channels as u32,
        };
        (64 * voxel) as f64
    }
}

/// What the blocks of a sample come to, in units of the volume.
#[derive(Clone, Debug)]
pub struct Grown {
    /// Codebooks.
    pub stages: Vec<Stage>,
    /// Bits of codes, escapes and codebooks.
    pub bits: f64,
    /// Blocks that keep anything.
    pub kept: f64,
    /// Squared error, in units of sums.
    pub error: f64,
}

/// The cheapest that a block came to so far.
#[derive(Copy, Clone)]
struct Least {
    cost: f64,
    error: f64,
    bits: f64,
}

/// What is left of the blocks of a sample once their means are taken away.
#[must_use]
pub fn residuals(vectors: &Vectors, means: Means) -> Vectors {
    let mut left = vectors.clone();
    let dimension = left.dimension();
    for row in left.values_mut().chunks_exact_mut(dimension) {
        let mean = means.decoded(means.code(row, None)).map(|mean| mean as f32);
        row.iter_mut().enumerate().for_each(|(i, v)| *v -= mean[i % means.channels]);
    }
    left
}

/// Squared norm.
#[must_use]
pub fn energy(row: &[f32]) -> f64 {
    row.iter().map(|v| f64::from(*v) * f64::from(*v)).sum()
}

/// Grows codebooks as long as they pay. With `held_out`, every third block does not train, and these alone are measured: many
/// codewords for few blocks then look no better than they are.
///
/// # Errors
/// When `run` was cancelled.
pub fn grow(
    sample: &Sample,
    wanted: &Wanted,
    with: &TrainingSettings,
    held_out: bool,
    run: &Progress<'_>,
) -> Result<Grown, Cancelled> {
    let measures = |i: usize| !held_out || i % 3 == 2;
    let scale = sample.scale * if held_out { 3.0 } else { 1.0 };
    let mut left = residuals(&sample.vectors, wanted.means);
    let (count, dimension, width) = (left.len(), left.dimension(), f64::from(wanted.width()));
    let code_price = wanted.price * width;
    let mut errors: Vec<f64> = (0..count).map(|i| energy(left.vector(i))).collect();
    let of_error = |error: f64, codes: f64| {
        let plain = Least { cost: error + code_price * codes, error, bits: width * codes };
        match wanted.expected.direct(error, wanted.price) {
            Some(d) if d.cost < error => {
                Least { cost: d.cost + code_price * codes, error: d.error, bits: width * codes + d.bits }
            }
            _ => plain,
        }
    };
    let mut least: Vec<Least> = errors.iter().map(|error| of_error(*error, 0.0)).collect();
    let (mut stages, mut book_bits) = (Vec::new(), 0.0);
    let (mut size, mut halvings) = (wanted.size, 0);
    while (stages.len() as u32) < wanted.stages {
        let open: Vec<usize> = (0..count).filter(|i| errors[*i] > OPEN * code_price).collect();
        let teaches = |i: &&usize| (!held_out || **i % 3 != 2) && wanted.trains(errors[**i]);
        let taught: Vec<usize> = open.iter().filter(teaches).copied().collect();
        let every = taught.len().div_ceil(MOST_BLOCKS * size).max(1);
        let taught: Vec<usize> = taught.into_iter().step_by(every).collect();
        let most = (taught.len() as f64 / FEWEST_BLOCKS) as usize;
        if size.min(most) < 2 {
            break;
        }
        let mut vectors = Vectors::with_room_for(taught.len(), dimension);
        taught.iter().for_each(|i| vectors.push(left.vector(*i), left.weight(*i)));
        let seed = with.seed.wrapping_add(stages.len() as u64);
        let stage = Stage::train(&vectors, (size.min(most), false), wanted.entries, with, seed, run)?;
        drop(vectors);
        let rows: Vec<f32> = open.iter().flat_map(|i| left.vector(*i)).copied().collect();
        let nearest = Search::new(&stage.codebook, None).all(&Vectors::of_rows(dimension, rows));
        let depth = stages.len() as f64 + 1.0;
        let found: Vec<Least> = nearest.iter().map(|n| of_error(n.distance, depth)).collect();
        let gain = |(i, found): (&usize, &Least)| left.weight(*i) * (least[*i].cost - found.cost).max(0.0);
        let measured = open.iter().zip(&found).filter(|(i, _)| measures(**i));
        let gained: f64 = measured.map(gain).sum::<f64>() * scale;
        let bits = stage.codebook.size() as f64 * wanted.codeword_bits();
        if gained <= wanted.price * bits {
            halvings += 1;
            size = stage.codebook.size() / 2;
            if halvings > HALVINGS {
                break;
            }
            continue;
        }
        for ((i, nearest), found) in open.iter().zip(&nearest).zip(&found) {
            if nearest.distance < errors[*i] {
                errors[*i] = nearest.distance;
                let row = &mut left.values_mut()[i * dimension..(i + 1) * dimension];
                subtract(row, stage.codebook.codeword(nearest.index as usize));
            }
            if found.cost < least[*i].cost {
                least[*i] = *found;
            }
        }
        book_bits += bits;
        stages.push(stage);
    }
    let mut grown = Grown { stages, bits: book_bits, kept: 0.0, error: 0.0 };
    for (i, least) in least.iter().enumerate().filter(|(i, _)| measures(*i)) {
        let blocks = left.weight(i) * scale;
        grown.bits += blocks * least.bits;
        grown.error += blocks * least.error;
        grown.kept += if least.bits > 0.0 { blocks } else { 0.0 };
    }
    Ok(grown)
}

/// The codes of a block that pay, code 0 (the zero vector) from where on it keeps none, and its squared error then. `paths` are the
/// errors and codes of none, one, … stages.
#[must_use]
pub fn kept_codes(paths: &[(f64, Vec<u16>)], stages: usize, code_price: f64) -> (Vec<u32>, f64) {
    let cost = |n: usize| paths[n].0 + code_price * n as f64;
    let best = (0..paths.len()).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(0);
    let codes = paths[best].1.iter().map(|code| u32::from(*code));
    (codes.chain(std::iter::repeat(0)).take(stages).collect(), paths[best].0)
}
