//! The payload `fixed`: how wide each partition's codes are, and a frame of them.

use cvr_core::codec::EncodeError;
use serde_json::json;

use crate::allocate::{Choice, allocate};
use crate::blocks::{Domain, Sample};
use crate::books::Book;
use crate::encode::{Coded, Sets, Work, Written, forms};
use crate::geometry::VOXELS;
use crate::payload::{fixed_frame, fixed_words, mean_width};
use crate::settings::{CODE_BITS, Target};
use crate::table::{Partition, Table};
use crate::train::Trainer;

/// Widths at which training curves are measured.
const MEASURED: [u32; 4] = [3, 5, 7, 9];
/// Blocks on which they are measured.
const OVERVIEW: u64 = 12288;
/// Widths of a code that a stream may have beside none.
const WIDTHS: std::ops::RangeInclusive<u32> = 4..=16;
/// How many budgets are tried for a PSNR.
const SEARCH: usize = 12;
/// How often the widths are chosen anew.
const TRIES: usize = 8;

/// What is to be expected of codebooks.
#[derive(Debug)]
struct Plan {
    /// By partition, the logarithm of the part of the error that is left at each of the widths that were measured.
    curves: [Vec<f64>; 3],
    measured: Vec<u32>,
    /// Mean square after the means, in units of sums.
    mean_square: f64,
    /// Largest less smallest mean, in units of sums.
    mean_span: f64,
    /// Most bits of a code that there are blocks for.
    widest: u32,
}

/// Widths, and the error (root mean square, in units of sums) that they are expected to leave.
#[derive(Copy, Clone, Debug, PartialEq)]
struct Widths {
    codes: [u32; 3],
    expected: f64,
}

impl Plan {
    fn measure(work: &Work<'_>) -> Result<Self, EncodeError> {
        let domains: Vec<_> = work.domains().cloned().collect();
        let seed = work.options.seed;
        let sample = Sample::draw(work.source, &domains, work.quantiser, OVERVIEW, seed, work.run)?;
        let trainer = Trainer::new(&sample, work.training(true));
        // What 38 dB leave, to begin with.
        let expected = 0.0126 * work.span / work.unit();
        let most = (sample.len() / 3).max(1).ilog2();
        let measured: Vec<u32> = MEASURED.into_iter().filter(|w| *w <= most).collect();
        let threshold = work.threshold(expected);
        let (curves, mean_square) =
            trainer.curves(&measured, work.mean_shift(expected), threshold, work.run)?;
        let means =
            sample.values.chunks_exact(VOXELS).map(|b| b.iter().map(|v| f64::from(*v)).sum::<f64>() / 64.0);
        let (low, high) =
            means.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), m| (low.min(m), high.max(m)));
        // Sub-volumes are trained one by one: none has codewords for more blocks than the smallest has.
        let fewest = domains.iter().map(Domain::blocks).min().unwrap_or(1);
        let widest = fewest.max(1).ilog2().clamp(1, *WIDTHS.end());
        Ok(Self { curves, measured, mean_square, mean_span: high - low, widest })
    }

    /// The logarithm of the part that a code of `width` bits leaves, between and beyond what was measured.
    fn left(&self, partition: usize, width: u32) -> f64 {
        let points: Vec<(f64, f64)> = std::iter::once((0.0, 0.0))
            .chain(self.measured.iter().map(|w| f64::from(*w)).zip(self.curves[partition].iter().copied()))
            .collect();
        let width = f64::from(width);
        let after = points.iter().position(|p| p.0 >= width).unwrap_or(points.len() - 1).max(1);
        let (Some(a), Some(b)) = (points.get(after - 1), points.get(after)) else { return 0.0 };
        a.1 + (b.1 - a.1) * (width - a.0) / (b.0 - a.0)
    }

    fn mean_bits(&self, shift: u32) -> f64 {
        (self.mean_span / f64::from(1_u32 << shift) + 2.0).log2().ceil().max(1.0)
    }

    fn expected(&self, codes: [u32; 3]) -> f64 {
        let left: f64 = codes.into_iter().enumerate().map(|(p, w)| self.left(p, w)).sum();
        (self.mean_square * left.exp()).sqrt().max(0.5)
    }

    /// Widths within `budget` for all codes and codebooks, and with `with_means` the means.
    fn widths(&self, work: &Work<'_>, budget: f64, with_means: bool) -> Widths {
        if work.options.index_bits > 0 {
            let codes = [work.options.index_bits; 3];
            return Widths { codes, expected: self.expected(codes) };
        }
        let book_bits = (VOXELS as u32 * work.options.entry_bits) as f64 * work.tables();
        let choice = |partition: usize, width: u32| {
            let books = if width == 0 { 0.0 } else { book_bits * f64::from(1_u32 << width) };
            Choice { bits: work.blocks() * f64::from(width) + books, left: self.left(partition, width) }
        };
        let widths: Vec<u32> = std::iter::once(0).chain(WIDTHS.filter(|w| *w <= self.widest)).collect();
        let curves: Vec<Vec<Choice>> =
            (0..3).map(|p| widths.iter().map(|w| choice(p, *w)).collect()).collect();
        let mut found = Widths { codes: [0; 3], expected: self.expected([0; 3]) };
        for _ in 0..3 {
            let means = if with_means { self.mean_bits(work.mean_shift(found.expected)) } else { 0.0 };
            let chosen = allocate(&curves, budget - means * work.blocks());
            let codes = [0, 1, 2].map(|p| widths[chosen[p]]);
            found = Widths { codes, expected: self.expected(codes) };
        }
        found
    }
}

/// Codebooks and codes of all tables.
///
/// # Errors
/// Those of reading, and when the run was cancelled.
pub fn encode(work: &Work<'_>) -> Result<Sets, EncodeError> {
    let plan = Plan::measure(work)?;
    match work.options.target {
        Target::Codes => {
            // What three codes of 8 bits take, and their codebooks.
            let books = f64::from(CODE_BITS << 5) * VOXELS as f64 * f64::from(work.options.entry_bits);
            code(work, plan.widths(work, f64::from(CODE_BITS) * work.blocks() + books * work.tables(), false))
        }
        Target::Rate(rate) => {
            let most = rate * work.samples() - work.overhead(3);
            let mut budget = most;
            for _ in 1..TRIES {
                let coded = code(work, plan.widths(work, budget, true))?;
                let excess = bits(work, &coded) - most;
                if excess <= 0.0 || budget < 0.0 || work.options.index_bits > 0 {
                    return Ok(coded);
                }
                budget -= excess * 1.01 + 8.0 * work.blocks() / 64.0;
            }
            code(work, plan.widths(work, budget, true))
        }
        Target::Psnr(psnr) | Target::Both { psnr, .. } => least(work, &plan, psnr),
    }
}

/// The least rate that reaches a PSNR, to within a fiftieth: budgets from the one that the curves promise on.
fn least(work: &Work<'_>, plan: &Plan, psnr: f64) -> Result<Sets, EncodeError> {
    let error = work.error_of(psnr);
    let wanted = (error / work.samples()).sqrt() / work.unit();
    let at = |budget: f64| plan.widths(work, budget, true);
    let most = at(f64::INFINITY);
    // Means of one bit, to begin with.
    let mut budget = work.blocks();
    while at(budget).expected > wanted && at(budget) != most {
        budget *= 1.05;
    }
    let mut missed = 0.0_f64;
    let mut reached: Option<(f64, Sets)> = None;
    for _ in 0..SEARCH {
        let coded = code(work, at(budget))?;
        if total_error(&coded) <= error {
            reached = Some((budget, coded));
        } else {
            missed = missed.max(budget);
            if at(budget) == most {
                break;
            }
        }
        budget = match &reached {
            Some((known, _)) if known / missed < 1.02 || at(*known) == at(missed * 1.001) => break,
            Some((known, _)) if missed > 0.0 => (known * missed).sqrt(),
            Some((known, _)) => known / 1.5,
            None => missed * 1.2,
        };
    }
    match reached {
        Some((_, coded)) => Ok(coded),
        None => code(work, most),
    }
}

/// The squared error of everything, in data units.
fn total_error(coded: &[Vec<Coded>]) -> f64 {
    let planes = coded.iter().flatten().flat_map(|c| &c.planes);
    planes.flat_map(|p| p.errors.iter().skip(p.books).step_by(p.books + 1)).map(|e| f64::from(*e)).sum()
}

/// Bits of means, codes and codebooks.
pub fn bits(work: &Work<'_>, coded: &[Vec<Coded>]) -> f64 {
    let entry_bits = f64::from(work.options.entry_bits);
    let of_table = |c: &Coded| {
        let entries: usize = c.books.iter().map(|b| b.size() * VOXELS).sum();
        let blocks: usize = c.planes.iter().map(|p| p.means.len()).sum();
        entries as f64 * entry_bits + table(c).block_bits() as f64 * blocks as f64
    };
    coded.iter().flatten().map(of_table).sum()
}

fn code(work: &Work<'_>, widths: Widths) -> Result<Sets, EncodeError> {
    let training = work.training(false);
    let (mean_shift, threshold) = (work.mean_shift(widths.expected), work.threshold(widths.expected));
    let mut seed = work.options.seed;
    let mut sets = Vec::new();
    for set in &work.sets {
        let mut coded = Vec::new();
        for domain in set {
            let domains = std::slice::from_ref(domain);
            let count = work.options.training_blocks;
            let sample = Sample::draw(work.source, domains, work.quantiser, count, seed, work.run)?;
            seed = seed.wrapping_add(1);
            let books =
                Trainer::new(&sample, training).fixed(widths.codes, mean_shift, threshold, work.run)?;
            drop(sample);
            let planes = work.coder(&books, mean_shift, 0.0).code(work.source, domain, work.run)?;
            coded.push(Coded { books, mean_shift, planes });
        }
        sets.push(coded);
    }
    Ok(sets)
}

/// The table of some codes, but for where they and the codebooks lie.
fn table(coded: &Coded) -> Table {
    let means: Vec<u32> = coded.planes.iter().flat_map(|p| p.means.iter().copied()).collect();
    let (mean_base, width) = mean_width(&means);
    let books = forms(&coded.books, &mut 0, true);
    Table { mean_shift: coded.mean_shift, width, mean_base, start: 0, channel_words: 0, books }
}

/// Tables and frames.
pub fn written(work: &Work<'_>, coded: &[Vec<Coded>]) -> Written {
    let channels = work.layout.channels as usize;
    let (mut tables, mut frames) = (Vec::new(), Vec::new());
    for (set, domains) in coded.iter().zip(&work.sets) {
        let mut of_set: Vec<Table> = set.iter().map(table).collect();
        let (mut first, mut start) = (0, 0);
        for ((table, coded), domain) in of_set.iter_mut().zip(set).zip(domains) {
            table.books = forms(&coded.books, &mut first, true);
            table.start = start;
            start += fixed_words(table, domain.plane_blocks() as u64) as u32;
        }
        of_set.iter_mut().for_each(|table| table.channel_words = start);
        for frame in 0..set.first().map_or(0, |c| c.planes.len() / channels) {
            let planes: Vec<_> =
                set.iter().map(|c| &c.planes[frame * channels..(frame + 1) * channels]).collect();
            frames.push((Vec::new(), fixed_frame(&of_set, &planes)));
        }
        tables.push(of_set);
    }
    let widths = coded.iter().flatten().next().map(|c| c.books.iter().map(Book::width).collect::<Vec<_>>());
    let chapters =
        coded.iter().flatten().next().map(|c| c.books.iter().map(Book::named_chapters).collect::<Vec<_>>());
    let training = work.record(coded, &json!({ "widths": widths, "chapters": chapters }));
    Written { tables, books: Partition::ALL.len() as u32, frames, notes: notes(work, coded), training }
}

fn notes(work: &Work<'_>, coded: &[Vec<Coded>]) -> Vec<String> {
    let mut notes = Vec::new();
    match work.options.target {
        Target::Psnr(psnr) if total_error(coded) > work.error_of(psnr) => notes.push(format!(
            "{:.2} dB where {psnr} were asked for: one code per partition reaches no more",
            work.psnr(total_error(coded))
        )),
        Target::Rate(rate) => {
            let found = (bits(work, coded) + work.overhead(3)) / work.samples();
            if found > rate {
                notes.push(format!("about {found:.3} bits per sample where {rate} were asked for: means, header and a codeword each take more"));
            }
        }
        _ => {}
    }
    notes
}
