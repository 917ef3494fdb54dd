//! The payload `variable`: as many codebooks as pay, and for each block as many codes as pay.

mod bricks;
mod cost;
mod frame;
mod growth;
mod point;
mod rate_control;
mod search;
mod trials;

use cvr_core::codec::EncodeError;
use rayon::prelude::*;
use serde_json::json;

use crate::encode::closed_loop::Plane;
use crate::encode::sample::Sample;
use crate::encode::train::book::Book;
use crate::encode::train::trainer::Trainer;
use crate::encode::tuned::trials::{LEAST_ERROR, SOME};
use crate::encode::tuned::variable::{COARSER, DAMPED, ENOUGH, FINER, OFF, OFF_OF_SOME, SAME, TRIES};
use crate::encode::work::{Coded, Kept, Sets, Work};
use crate::encode::write::{Written, forms};
use crate::settings::Target;
use crate::stream::geometry::{EDGE, Geometry, Parameters, Payload, VALUE_BITS, block_grid};
use crate::stream::scale::Scale;
use crate::stream::table::{BookForm, Partition, Table};
use bricks::Bricks;
use cost::aim;
use frame::variable_frame;
use growth::Growth;
use rate_control::{Aim, Settled, Sum, best_counts, settle};
use search::{Plan, plan};

/// Codebooks and codes of all tables, and the number of codes that each block keeps. Sets the bits of entries that fit
/// them.
///
/// # Errors
/// Those of reading, and when the run was cancelled.
pub fn encode(work: &mut Work<'_>) -> Result<(Sets, Kept), EncodeError> {
    let mut plan = plan(work)?;
    work.options.entry_bits = Some(plan.entry_bits);
    let work = &*work;
    let aim = aim(work);
    let some = work.blocks() / work.tables() <= SOME;
    let (tries, near) = if some { (2 * TRIES, OFF_OF_SOME) } else { (TRIES, OFF) };
    let mut coarser = false;
    let mut best: Option<(Settled, Sets)> = None;
    for _ in 0..tries {
        let point = plan.point;
        let coded = code(work, &plan)?;
        let bricks = Bricks::of(work, &coded);
        let settled = settle(aim, point.price() * work.unit().powi(2), |price| bricks.sums(price));
        drop(bricks);
        let better = best.as_ref().is_none_or(|b| aim.order(settled.sum, b.0.sum).is_lt());
        if better {
            best = Some((settled, coded));
        }
        // The codebooks were made for another price.
        let off = point.off(settled.price / work.unit().powi(2));
        let missed = matches!(aim, Aim::Error(_)) && !aim.met(settled.sum);
        coarser |= !missed && off.abs() < near;
        let next = match (coarser, missed) {
            (_, true) if !plan.sizes.is_empty() && better => {
                // Codebooks of these sizes miss the target. Add as many as pay.
                plan.sizes.clear();
                continue;
            }
            // Codebooks of given sizes are retrained while that helps.
            _ if !plan.sizes.is_empty() && !better => break,
            // Codebooks for only the worst blocks may do better than those for all blocks in which a code pays.
            (true, _) if some && better => COARSER * point.error,
            (true, _) => break,
            (false, true) => FINER * point.error,
            (false, false) => point.error * (DAMPED * off).exp(),
        };
        let next = next.clamp(LEAST_ERROR, f64::from(1 << VALUE_BITS));
        if (next / point.error).ln().abs() < SAME {
            break;
        }
        plan.point.error = next;
    }
    let Some((settled, mut coded)) = best else {
        return Err(EncodeError::Unsupported("no blocks".to_owned()));
    };
    let mut all = Vec::new();
    for coded in &mut coded {
        let mut of_set = Vec::new();
        for coded in coded {
            coded.books.truncate(settled.books);
            let price = settled.price * width(coded);
            let kept: Vec<_> = coded.planes.iter().map(|p| kept(p, coded.books.len(), price)).collect();
            let most = kept.iter().flatten().copied().max().unwrap_or(0);
            coded.books.truncate(most.into());
            of_set.push(kept);
        }
        all.push(of_set);
    }
    Ok((coded, all))
}

/// Bits of a code.
fn width(coded: &Coded) -> f64 {
    f64::from(coded.books.iter().map(Book::width).max().unwrap_or(0))
}

fn code(work: &Work<'_>, plan: &Plan) -> Result<Sets, EncodeError> {
    let point = plan.point;
    let training = work.training(false);
    let mean_shift = work.mean_shift(point.of_means());
    let threshold = work.threshold(point.error);
    // Below the cost of a code. Otherwise a lower price would find blocks without codes.
    let part = ENOUGH[usize::from(!plan.sizes.is_empty())];
    let enough = part * point.price() * work.unit().powi(2) * f64::from(point.width);
    let mut seed = work.options.training.seed;
    let mut sets = Vec::new();
    for set in &work.sets {
        let mut coded = Vec::new();
        for domain in set {
            let domains = std::slice::from_ref(domain);
            let count = work.options.training.training_blocks;
            let sample = Sample::draw(work.source, domains, work.quantiser, count, seed, work.run)?;
            seed = seed.wrapping_add(1);
            let mut trainer = Trainer::new(&sample, training);
            trainer.most_bits = aim(work).most_bits();
            let code_price = point.price() * f64::from(point.width);
            let mut growth = Growth::new(&trainer, code_price, (mean_shift, threshold), false);
            if plan.sizes.is_empty() {
                growth.at_price(1 << point.width, point.price(), work.run)?;
            } else {
                growth.of_sizes(&plan.sizes, work.run)?;
            }
            let books = growth.into_books();
            drop(trainer);
            drop(sample);
            let planes = work.coder(&books, mean_shift, enough).code(work.source, domain, work.run)?;
            coded.push(Coded { books, mean_shift, planes });
        }
        sets.push(coded);
    }
    Ok(sets)
}

/// The number of codes that each block keeps, if the first `books` codebooks are kept and a code costs `price`.
fn kept(plane: &Plane, books: usize, price: f64) -> Vec<u8> {
    let prices = vec![price; books + 1];
    let of_block = |errors: &[f32]| {
        let mut kept = 0;
        best_counts(|n| errors[n].into(), &prices, |_, count, _| kept = count as u8);
        kept
    };
    plane.errors.par_chunks_exact(plane.books + 1).map(of_block).collect()
}

/// Tables and frames.
///
/// # Errors
/// When a frame has more than 2^32 words.
pub fn written(work: &Work<'_>, coded: &[Vec<Coded>], kept: &Kept) -> Result<Written, EncodeError> {
    let channels = work.layout.channels as usize;
    let books = coded.iter().flatten().map(|c| c.books.len()).max().unwrap_or(0) as u32;
    let geometry = Geometry::new(
        &work.layout,
        &Parameters {
            payload: Payload::Variable,
            grid: block_grid(work.layout.extent).to_array(),
            subvolume: work.options.subvolume,
            offset: work.quantiser.offset(),
            step: work.quantiser.step(),
            entry_bits: work.entry_bits(),
            books,
            tables: work.sets.len() as u32,
            entries: vec![0; work.sets.len()],
            frame_words: vec![0; work.layout.frames as usize],
            training: serde_json::Value::Null,
        },
    );
    let geometry = geometry.ok_or_else(|| EncodeError::Unsupported("sizes are out of range".to_owned()))?;
    let (mut tables, mut frames) = (Vec::new(), Vec::new());
    for (set, kept) in coded.iter().zip(kept.iter()) {
        let mut first = 0;
        let of_table = |c: &Coded| {
            let mut forms = forms(&c.books, &mut first, false);
            let none =
                BookForm { first: 0, size: 0, width: 0, scale: Scale::ONE, partition: Partition::High };
            forms.resize(books as usize, none);
            let width = width(c) as u32;
            Table { mean_shift: c.mean_shift, width, mean_base: 0, start: 0, channel_words: 0, books: forms }
        };
        let of_set: Vec<Table> = set.iter().map(of_table).collect();
        for frame in 0..set.first().map_or(0, |c| c.planes.len() / channels) {
            let part = frame * channels..(frame + 1) * channels;
            let planes: Vec<_> = set.iter().map(|c| &c.planes[part.clone()]).collect();
            let kept: Vec<_> = kept.iter().map(|k| &k[part.clone()]).collect();
            let frame = variable_frame(&geometry, &of_set, &planes, &kept).ok_or_else(|| {
                EncodeError::Unsupported("a frame takes more than 2^32 words; ask for less".to_owned())
            })?;
            frames.push(frame);
        }
        tables.push(of_set);
    }
    let counts = || kept.iter().flatten().flatten().flatten().map(|n| u64::from(*n));
    let training = work.record(
        coded,
        &json!({
            "codes": counts().sum::<u64>(),
            "blocks_without": counts().filter(|n| *n == 0).count(),
        }),
    );
    Ok(Written { tables, books, frames, notes: notes(work, coded, kept), training })
}

/// Approximate bits of the whole file.
pub fn bits(work: &Work<'_>, coded: &[Vec<Coded>], kept: &Kept) -> f64 {
    let kept: Vec<&Vec<Vec<u8>>> = kept.iter().flatten().collect();
    Bricks::of(work, coded).sum_of(&kept).bits
}

fn notes(work: &Work<'_>, coded: &[Vec<Coded>], kept: &Kept) -> Vec<String> {
    let kept: Vec<&Vec<Vec<u8>>> = kept.iter().flatten().collect();
    let Sum { bits, error } = Bricks::of(work, coded).sum_of(&kept);
    let rate = bits / work.samples();
    match work.options.target {
        Target::Psnr(psnr) if error > work.error_of(psnr) => {
            vec![format!(
                "{:.2} dB where {psnr} were asked for: further codebooks do not reach it",
                work.psnr(error)
            )]
        }
        Target::Rate(most) if rate > most => vec![format!(
            "about {rate:.3} bits per sample where {most} were asked for: means, heads and header take more"
        )],
        _ => Vec::new(),
    }
}

const _: () = assert!(EDGE == 4, "a brick is 16 voxels long");
