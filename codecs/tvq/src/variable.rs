//! The payload `variable`: codebooks as many as pay, and for each block as many codes as pay.

use cvr_core::codec::EncodeError;
use rayon::prelude::*;
use serde_json::json;

use crate::blocks::Sample;
use crate::books::Book;
use crate::code::Plane;
use crate::encode::{Coded, Sets, Work, Written, forms};
use crate::geometry::{
    BRICK, EDGE, Geometry, Parameters, Payload, VALUE_BITS, VOXELS, block_grid, number, positions,
};
use crate::payload::{brick_words, count_bits, mean_width, variable_frame};
use crate::plan::{LEAST_ERROR, PRICE, Point, fixed_bits, most_bits, plan};
use crate::settings::Target;
use crate::table::{BookForm, Partition, Table};
use crate::train::Trainer;

/// Codebooks are trained anew where the logarithm of the error at which a bit pays turns out to be off by this.
const OFF: f64 = 0.5;
/// How often codebooks are trained at most.
const TRIES: usize = 4;

/// By set, sub-volume and plane: how many codes each block keeps.
pub type Kept = Vec<Vec<Vec<Vec<u8>>>>;

/// Codebooks and codes of all tables, and how many codes each block keeps.
///
/// # Errors
/// Those of reading, and when the run was cancelled.
pub fn encode(work: &Work<'_>) -> Result<(Sets, Kept), EncodeError> {
    let mut point = plan(work)?;
    // The best so far: what it fails by (nothing, where the target is met), its price and its codes.
    let mut best: Option<([f64; 2], f64, Sets)> = None;
    for _ in 0..TRIES {
        let coded = code(work, point)?;
        let price = choose(work, &coded, point.price() * work.unit().powi(2));
        let sum = total_at(work, &coded, price);
        // By how much a target is missed, then what else is to be least.
        let (missed, rank) = match work.options.target {
            Target::Psnr(psnr) if sum.error > work.error_of(psnr) => (true, [sum.error, 0.0]),
            Target::Psnr(_) => (false, [0.0, sum.bits]),
            _ => (false, [0.0, sum.error]),
        };
        if best.as_ref().is_none_or(|b| rank < b.0) {
            best = Some((rank, price, coded));
        }
        // What pays at this price is not what the codebooks were made for.
        let suited = (price / PRICE).sqrt() / work.unit();
        let off = (suited / point.error).ln();
        let next = if missed { 0.7 * point.error } else { point.error * (0.7 * off).exp() };
        let next = next.clamp(LEAST_ERROR, f64::from(1 << VALUE_BITS));
        if (!missed && off.abs() < OFF) || (next / point.error).ln().abs() < 0.1 {
            break;
        }
        point.error = next;
    }
    let Some((_, price, mut coded)) = best else {
        return Err(EncodeError::Unsupported("no blocks".to_owned()));
    };
    let kept: Kept = coded
        .iter()
        .map(|set| set.iter().map(|c| c.planes.iter().map(|p| kept(p, price * width(c))).collect()).collect())
        .collect();
    for (coded, kept) in coded.iter_mut().flatten().zip(kept.iter().flatten()) {
        let most = kept.iter().flatten().copied().max().unwrap_or(0);
        coded.books.truncate(most.into());
    }
    Ok((coded, kept))
}

/// Bits of a code.
fn width(coded: &Coded) -> f64 {
    f64::from(coded.books.iter().map(Book::width).max().unwrap_or(0))
}

fn code(work: &Work<'_>, point: Point) -> Result<Sets, EncodeError> {
    let training = work.training(false);
    let mean_shift = work.mean_shift(point.error);
    let threshold = work.threshold(point.error);
    // Half of what a code costs, lest a somewhat lower price finds blocks without codes.
    let enough = 0.5 * point.price() * work.unit().powi(2) * f64::from(point.width);
    let mut seed = work.options.seed;
    let mut sets = Vec::new();
    for set in &work.sets {
        let mut coded = Vec::new();
        for domain in set {
            let domains = std::slice::from_ref(domain);
            let count = work.options.training_blocks;
            let sample = Sample::draw(work.source, domains, work.quantiser, count, seed, work.run)?;
            seed = seed.wrapping_add(1);
            let trainer = Trainer::new(&sample, training);
            let books =
                trainer.variable(point.width, point.price(), (mean_shift, threshold), false, work.run)?.books;
            drop(trainer);
            drop(sample);
            let planes = work.coder(&books, mean_shift, enough).code(work.source, domain, work.run)?;
            coded.push(Coded { books, mean_shift, planes });
        }
        sets.push(coded);
    }
    Ok(sets)
}

/// What a price leads to.
#[derive(Copy, Clone, Debug, Default)]
struct Sum {
    bits: f64,
    /// In data units.
    error: f64,
}

/// The number of codes at which `error + price · codes` is least; of equal ones the first.
fn best_count(errors: &[f32], price: f64) -> usize {
    let mut best = (f64::INFINITY, 0);
    for (n, error) in errors.iter().enumerate() {
        let cost = f64::from(*error) + price * n as f64;
        if cost < best.0 {
            best = (cost, n);
        }
    }
    best.1
}

fn kept(plane: &Plane, code_price: f64) -> Vec<u8> {
    let blocks = plane.errors.par_chunks_exact(plane.books + 1);
    blocks.map(|errors| best_count(errors, code_price) as u8).collect()
}

/// What a brick takes and leaves.
fn of_brick(plane: &Plane, size: [u32; 3], brick: [u32; 3], width: u32, count: impl Fn(usize) -> u8) -> Sum {
    let first = brick.map(|b| b * BRICK);
    let cut = [0, 1, 2].map(|a| BRICK.min(size[a] - first[a]));
    let blocks = positions(cut).map(|p| number([0, 1, 2].map(|a| first[a] + p[a]), size));
    let (mut error, mut codes, mut most, mut means) = (0.0, 0, 0, Vec::with_capacity(VOXELS));
    for n in blocks {
        let kept = count(n);
        error += f64::from(plane.errors[n * (plane.books + 1) + usize::from(kept)]);
        codes += u32::from(kept);
        most = most.max(kept);
        means.push(plane.means[n]);
    }
    let mean_bits = mean_width(&means).1 * means.len() as u32;
    let words = brick_words(count_bits(std::iter::once(most)), mean_bits, codes, width);
    Sum { bits: 32.0 * f64::from(words), error }
}

/// Bits of everything and squared error, where every block keeps as many codes as `count` says by its domain, plane and
/// number.
fn total(
    work: &Work<'_>,
    coded: &[Vec<Coded>],
    count: impl Fn(usize, usize, &Plane, usize) -> u8 + Sync,
) -> Sum {
    let most = coded.iter().flatten().map(|c| c.books.len()).max().unwrap_or(0);
    let codewords: usize = coded.iter().flatten().flat_map(|c| &c.books).map(Book::size).sum();
    let mut sum = Sum { bits: fixed_bits(work, most as u32, codewords as f64), error: 0.0 };
    for (d, (c, domain)) in coded.iter().flatten().zip(work.domains()).enumerate() {
        let width = width(c) as u32;
        let [x, y, z] = domain.size.map(|s| s.div_ceil(BRICK));
        for (p, plane) in c.planes.iter().enumerate() {
            let of_layer = |z: u32| {
                let bricks = positions([x, y, 1]).map(|b| [b[0], b[1], z]);
                bricks.fold(Sum::default(), |sum, brick| {
                    let n = of_brick(plane, domain.size, brick, width, |n| count(d, p, plane, n));
                    Sum { bits: sum.bits + n.bits, error: sum.error + n.error }
                })
            };
            let layers: Vec<Sum> = (0..z).into_par_iter().map(of_layer).collect();
            for layer in layers {
                sum.bits += layer.bits;
                sum.error += layer.error;
            }
        }
    }
    sum
}

/// The same, where every block keeps what pays at a price in data units.
fn total_at(work: &Work<'_>, coded: &[Vec<Coded>], price: f64) -> Sum {
    let prices: Vec<f64> = coded.iter().flatten().map(|c| price * width(c)).collect();
    total(work, coded, |d, _, plane, n| {
        let errors = &plane.errors[n * (plane.books + 1)..(n + 1) * (plane.books + 1)];
        best_count(errors, prices[d]) as u8
    })
}

/// The price, in data units, at which the target is just met; about `price`.
fn choose(work: &Work<'_>, coded: &[Vec<Coded>], price: f64) -> f64 {
    let met = |price: f64| match work.options.target {
        // A higher price asks for less.
        Target::Psnr(psnr) => total_at(work, coded, price).error > work.error_of(psnr),
        _ => total_at(work, coded, price).bits <= most_bits(work),
    };
    let (mut low, mut high) = ((price * 1e-6).max(1e-300).ln(), (price * 1e6).max(1e-300).ln());
    for _ in 0..36 {
        let middle = 0.5 * (low + high);
        if met(middle.exp()) { high = middle } else { low = middle }
    }
    // Rates stay below, PSNRs above.
    if matches!(work.options.target, Target::Psnr(_)) { low.exp() } else { high.exp() }
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
            entry_bits: work.options.entry_bits,
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
            let none = BookForm { first: 0, size: 0, width: 0, shift: 0, partition: Partition::High };
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

/// Bits of the whole file, about.
pub fn bits(work: &Work<'_>, coded: &[Vec<Coded>], kept: &Kept) -> f64 {
    let kept: Vec<&Vec<Vec<u8>>> = kept.iter().flatten().collect();
    total(work, coded, |d, p, _, n| kept[d][p][n]).bits
}

fn notes(work: &Work<'_>, coded: &[Vec<Coded>], kept: &Kept) -> Vec<String> {
    let kept: Vec<&Vec<Vec<u8>>> = kept.iter().flatten().collect();
    let Sum { bits, error } = total(work, coded, |d, p, _, n| kept[d][p][n]);
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
