//! The payload `fixed`: finds codebooks that reach a target, and codes frames.

mod expected;
mod frame;
mod sizes;

use cvr_core::codec::EncodeError;
use cvr_groups::mean_width;
use serde_json::json;

use crate::encode::sample::Sample;
use crate::encode::train::book::Book;
use crate::encode::train::trainer::Trainer;
use crate::encode::tuned::fixed::{BEYOND, BUDGETS, DOWN, FIRST_STEP, NEAR, TRIES, UP};
use crate::encode::work::{Coded, Sets, Work};
use crate::encode::write::{Written, forms};
use crate::settings::{CODE_BITS, Target};
use crate::stream::geometry::VOXELS;
use crate::stream::table::{Partition, Table, fixed_words};
use expected::training_blocks;
use frame::fixed_frame;
use sizes::{Plan, Shape, Sizes, given};

/// What reaches most.
const THREE: Shape = Shape::Best(3);

/// Codebooks and codes of all tables.
///
/// # Errors
/// Those of reading, and when the run was cancelled.
pub fn encode(work: &Work<'_>) -> Result<Sets, EncodeError> {
    let plan = Plan::measure(work)?;
    match work.options.target {
        Target::Codes => {
            if let Some(sizes) = plan.three_of_eight_bits(work) {
                return code(work, sizes);
            }
            // Bits of three codes of 8 bits, and of their codebooks.
            let books = f64::from(CODE_BITS << 5) * VOXELS as f64 * f64::from(work.entry_bits());
            let budget = f64::from(CODE_BITS) * work.blocks() + books * work.tables();
            let coded = |shape| code(work, plan.sizes(work, budget, false, shape));
            Ok(best_of(&plan.counts(work, budget, false), coded)?.1)
        }
        Target::Rate(rate) => {
            let most = rate * work.samples() - work.overhead(3);
            let coded = |shape| within(work, &plan, most, shape);
            Ok(best_of(&plan.shapes(work, most), coded)?.1)
        }
        Target::Psnr(psnr) | Target::Both { psnr, .. } => least(work, &plan, psnr),
    }
}

/// The shape that leaves the least error, with its codes.
fn best_of(
    shapes: &[Shape],
    code: impl Fn(Shape) -> Result<Sets, EncodeError>,
) -> Result<(Shape, Sets), EncodeError> {
    let mut best: Option<(f64, Shape, Sets)> = None;
    for &shape in shapes {
        let coded = code(shape)?;
        let error = total_error(&coded);
        if best.as_ref().is_none_or(|best| error < best.0) {
            best = Some((error, shape, coded));
        }
    }
    best.map(|(_, shape, coded)| (shape, coded))
        .ok_or_else(|| EncodeError::Unsupported("no codebooks to try".to_owned()))
}

/// Codebooks of a shape, with at most `most` bits.
fn within(work: &Work<'_>, plan: &Plan, most: f64, shape: Shape) -> Result<Sets, EncodeError> {
    let mut budget = most;
    for _ in 1..TRIES {
        let coded = code(work, plan.sizes(work, budget, true, shape))?;
        let excess = bits(work, &coded) - most;
        if excess <= 0.0 || budget < 0.0 || given(work).is_some() {
            return Ok(coded);
        }
        budget -= excess * BEYOND + 8.0 * work.blocks() / 64.0;
    }
    code(work, plan.sizes(work, budget, true, shape))
}

/// The least rate that reaches a PSNR, within a fiftieth. The search starts from the budget that the curves predict.
fn least(work: &Work<'_>, plan: &Plan, psnr: f64) -> Result<Sets, EncodeError> {
    let error = work.error_of(psnr);
    let wanted = (error / work.samples()).sqrt() / work.unit();
    // The search begins with one bit per mean.
    let mut budget = work.blocks();
    let all = plan.sizes(work, f64::INFINITY, true, THREE);
    while (1..4).all(|count| {
        let sizes = plan.sizes(work, budget, true, Shape::Best(count));
        sizes.expected > wanted && sizes != all
    }) {
        budget *= FIRST_STEP;
    }
    let tried = |shape| code(work, plan.sizes(work, budget, true, shape));
    let (shape, _) = best_of(&plan.counts(work, budget, true), tried)?;
    let mut reached = search(work, plan, budget, (error, shape))?;
    if reached.is_none() && shape != THREE {
        reached = search(work, plan, budget, (error, THREE))?;
    }
    reached.map_or_else(|| code(work, all), Ok)
}

/// Codebooks of a shape that leave at most an error. `None` if they cannot. The search goes around a first budget.
fn search(
    work: &Work<'_>,
    plan: &Plan,
    mut budget: f64,
    (error, shape): (f64, Shape),
) -> Result<Option<Sets>, EncodeError> {
    let at = |budget: f64| plan.sizes(work, budget, true, shape);
    let most = at(f64::INFINITY);
    let mut missed = 0.0_f64;
    let mut reached: Option<(f64, Sets)> = None;
    for _ in 0..BUDGETS {
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
            Some((known, _)) if known / missed < NEAR || at(*known) == at(missed * 1.001) => break,
            Some((known, _)) if missed > 0.0 => (known * missed).sqrt(),
            Some((known, _)) => known / DOWN,
            None => missed * UP,
        };
    }
    Ok(reached.map(|(_, coded)| coded))
}

/// The total squared error, in data units.
fn total_error(coded: &[Vec<Coded>]) -> f64 {
    let planes = coded.iter().flatten().flat_map(|c| &c.planes);
    planes.flat_map(|p| p.errors.iter().skip(p.books).step_by(p.books + 1)).map(|e| f64::from(*e)).sum()
}

/// Bits of means, codes and codebooks.
pub fn bits(work: &Work<'_>, coded: &[Vec<Coded>]) -> f64 {
    let entry_bits = f64::from(work.entry_bits());
    let of_table = |c: &Coded| {
        let entries: usize = c.books.iter().map(|b| b.size() * VOXELS).sum();
        let blocks: usize = c.planes.iter().map(|p| p.means.len()).sum();
        entries as f64 * entry_bits + table(c).block_bits() as f64 * blocks as f64
    };
    coded.iter().flatten().map(of_table).sum()
}

fn code(work: &Work<'_>, sizes: Sizes) -> Result<Sets, EncodeError> {
    let training = work.training(false);
    let (mean_shift, threshold) = (work.mean_shift(sizes.expected), work.threshold(sizes.expected));
    let mut seed = work.options.training.seed;
    let mut sets = Vec::new();
    for set in &work.sets {
        let mut coded = Vec::new();
        for domain in set {
            let domains = std::slice::from_ref(domain);
            let count = training_blocks(work, sizes.books.into_iter().max().unwrap_or(1)) as u64;
            let sample = Sample::draw(work.source, domains, work.quantiser, count, seed, work.run)?;
            seed = seed.wrapping_add(1);
            let books =
                Trainer::new(&sample, training).fixed(sizes.books, mean_shift, threshold, work.run)?;
            drop(sample);
            let planes = work.coder(&books, mean_shift, 0.0).code(work.source, domain, work.run)?;
            coded.push(Coded { books, mean_shift, planes });
        }
        sets.push(coded);
    }
    Ok(sets)
}

/// The table of some codes, without the positions of indices and codebooks.
fn table(coded: &Coded) -> Table {
    let (mean_base, width) = mean_width(coded.planes.iter().flat_map(|p| p.means.iter().copied()));
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
