//! The payload `variable`: as many codebooks as pay, and for each block as many codes as pay.

mod cost;
mod escapes;
mod frame;
mod groups;
mod growth;
mod measured;
mod point;
mod search;
mod trials;

use cvr_core::codec::EncodeError;
pub use cvr_groups::Sum;
use cvr_groups::{Aim, Expected, Scale, Settled, settle};
use serde_json::json;

use crate::encode::sample::Sample;
use crate::encode::train::book::Book;
use crate::encode::train::trainer::Trainer;
use crate::encode::tuned::escapes::{FLOOR, FLOORS};
use crate::encode::tuned::trials::{LEAST_ERROR, SOME};
use crate::encode::tuned::variable::{COARSER, DAMPED, ENOUGH, FINER, OFF, OFF_OF_SOME, SAME, TRIES};
use crate::encode::work::{Coded, Kept, Sets, Work};
use crate::encode::write::{Written, forms};
use crate::settings::Target;
use crate::stream::geometry::{EDGE, Geometry, Parameters, Payload, VALUE_BITS, block_grid};
use crate::stream::table::{BookForm, Partition, Table};
use cost::aim;
use escapes::{AllWays, ways};
use frame::variable_frame;
use groups::groups;
use growth::Growth;
use search::{Plan, expectations, plan};

/// Codebooks and codes of all tables, what each block keeps, and what that comes to. Entries have as many bits as suits these from
/// then on.
///
/// # Errors
/// Those of reading, and when the run was cancelled.
pub fn encode(work: &mut Work<'_>) -> Result<(Sets, Kept, Sum), EncodeError> {
    let mut found: Option<(Attempt, Option<u32>)> = None;
    for expected in expectations(work) {
        let mut of = work.clone();
        let plan = plan(&of, expected)?;
        of.options.entry_bits = Some(plan.entry_bits);
        let attempt = attempt(&of, plan, expected)?;
        if found.as_ref().is_none_or(|b| aim(&of).order(attempt.settled.sum, b.0.settled.sum).is_lt()) {
            found = Some((attempt, of.options.entry_bits));
        }
    }
    let Some((Attempt { settled, sets: mut coded, ways }, entry_bits)) = found else {
        return Err(EncodeError::Unsupported("no blocks".to_owned()));
    };
    work.options.entry_bits = entry_bits;
    let work = &*work;
    let aim = aim(work);
    let (planes, sum) = groups(work, &coded, &ways).kept(aim, &settled);
    let (mut all, mut planes) = (Vec::new(), planes.into_iter());
    for (coded, domains) in coded.iter_mut().zip(&work.sets) {
        let mut of_set = Vec::new();
        for (coded, domain) in coded.iter_mut().zip(domains) {
            let mut kept = planes.next().unwrap_or_default();
            let most = kept.iter().flat_map(|plane| &plane.codes).copied().max().unwrap_or(0);
            coded.books.truncate(most.into());
            escapes::write(work, (coded, domain), &mut kept)?;
            of_set.push(kept);
        }
        all.push(of_set);
    }
    Ok((coded, all, sum))
}

/// Codebooks and codes of all tables, and what suits them.
struct Attempt {
    settled: Settled,
    sets: Sets,
    ways: AllWays,
}

/// The best codebooks that a plan leads to.
fn attempt(work: &Work<'_>, mut plan: Plan, expected: Expected) -> Result<Attempt, EncodeError> {
    let aim = aim(work);
    let some = work.blocks() / work.tables() <= SOME;
    let (tries, near) = if some { (2 * TRIES, OFF_OF_SOME) } else { (TRIES, OFF) };
    let mut coarser = false;
    let mut found: Option<Attempt> = None;
    for _ in 0..tries {
        let point = plan.point;
        let coded = code(work, &plan, expected)?;
        let (settled, ways) = settled(work, &coded, point.price() * work.unit().powi(2))?;
        let better = found.as_ref().is_none_or(|b| aim.order(settled.sum, b.settled.sum).is_lt());
        if better {
            found = Some(Attempt { settled, sets: coded, ways });
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
    found.ok_or_else(|| EncodeError::Unsupported("no blocks".to_owned()))
}

/// The count of codebooks and the price that suit some codes, and the ways to code blocks directly that bear on them. The price is
/// about `about`, in data units.
fn settled(work: &Work<'_>, coded: &Sets, about: f64) -> Result<(Settled, AllWays), EncodeError> {
    let mut floor = FLOOR * about;
    for left in (0..=FLOORS).rev() {
        let ways = ways(work, coded, floor)?;
        let groups = groups(work, coded, &ways);
        let settled = settle(aim(work), about, |price| groups.sums(price));
        drop(groups);
        if settled.price >= floor || left == 0 {
            return Ok((settled, ways));
        }
        // At a lower price more ways may pay, and the price is then higher than what was found without them.
        floor = if left == 1 { 0.0 } else { floor * FLOOR * FLOOR };
    }
    Err(EncodeError::Unsupported("no price".to_owned()))
}

/// Bits of a code.
fn width(coded: &Coded) -> f64 {
    f64::from(coded.books.iter().map(Book::width).max().unwrap_or(0))
}

fn code(work: &Work<'_>, plan: &Plan, expected: Expected) -> Result<Sets, EncodeError> {
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
            let mut growth = Growth::new(&trainer, code_price, (mean_shift, threshold), false, expected);
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

/// Tables and frames.
///
/// # Errors
/// When a frame has more than 2^32 words.
pub fn written(
    work: &Work<'_>,
    coded: &[Vec<Coded>],
    (kept, sum): (&Kept, Sum),
) -> Result<Written, EncodeError> {
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
    let planes = || kept.iter().flatten().flatten();
    let counts = || planes().flat_map(|plane| &plane.codes).map(|n| u64::from(*n));
    let training = work.record(
        coded,
        &json!({
            "codes": counts().sum::<u64>(),
            "blocks_without": counts().filter(|n| *n == 0).count(),
            "blocks_escaped": planes().flat_map(|plane| &plane.bits).filter(|bits| **bits > 0).count(),
        }),
    );
    Ok(Written { tables, books, frames, notes: notes(work, sum), training })
}

fn notes(work: &Work<'_>, Sum { bits, error }: Sum) -> Vec<String> {
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

const _: () = assert!(EDGE == 4, "a group is 16 voxels long");
