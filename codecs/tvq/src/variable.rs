//! The payload `variable`: codebooks as many as pay, and for each block as many codes as pay.

use cvr_core::codec::EncodeError;
use rayon::prelude::*;
use serde_json::json;

use crate::blocks::{Domain, Sample};
use crate::books::Book;
use crate::code::Plane;
use crate::encode::{Coded, Sets, Work, Written, forms};
use crate::geometry::{
    BRICK, EDGE, Geometry, HEAD_WORDS, Parameters, Payload, VALUE_BITS, VOXELS, block_grid, number, positions,
};
use crate::payload::{brick_words, count_bits, mean_width, variable_frame};
use crate::settings::{CODE_BITS, Target};
use crate::table::{BookForm, Partition, Table};
use crate::train::Trainer;

/// Blocks on which trials train.
const OVERVIEW: u64 = 32768;
/// Least error, in units of sums, at which a bit may pay.
const LEAST_ERROR: f64 = 0.5;
/// Codebooks are trained anew where the logarithm of the error at which a bit pays turns out to be off by this.
const OFF: f64 = 0.5;
/// Blocks of a table that are many.
const MANY: f64 = 65536.0;
/// Costs that differ by no more than this factor are about the same.
const ABOUT_AS_GOOD: f64 = 1.02;
/// Trials of one width.
const TRIALS: usize = 6;
/// How often codebooks are trained at most.
const TRIES: usize = 4;
/// Squared error of a block that one bit is worth, over the mean square of its voxels: a bit less in each of 64
/// dimensions would raise it by 2 ln 2.
const PRICE: f64 = 2.0 * std::f64::consts::LN_2;

/// By set, sub-volume and plane: how many codes each block keeps.
pub type Kept = Vec<Vec<Vec<Vec<u8>>>>;

/// What is sought before all blocks are coded: codes of how many bits, and the error at which a bit pays.
#[derive(Copy, Clone, Debug)]
struct Point {
    width: u32,
    /// Root mean square, in units of sums.
    error: f64,
}

/// What one trial promises.
#[derive(Copy, Clone, Debug)]
struct Promise {
    bits: f64,
    /// Squared error of everything, in units of sums.
    error: f64,
}

impl Point {
    /// Squared error that a bit is worth, in units of sums.
    fn price(self) -> f64 {
        PRICE * self.error * self.error
    }
}

/// Trials on few blocks.
struct Overview<'a, 'w> {
    work: &'a Work<'w>,
    trainer: Trainer<'a>,
    /// Means of all blocks in units of sums, by domain and plane.
    means: Vec<Vec<Plane>>,
}

impl Overview<'_, '_> {
    /// Bits of all means.
    fn mean_bits(&self, shift: u32) -> f64 {
        let domains = self.work.domains().zip(&self.means);
        domains
            .map(|(domain, planes)| planes.iter().map(|p| mean_bits(p, domain.size, shift)).sum::<f64>())
            .sum()
    }

    fn trial(&self, point: Point) -> Result<Promise, EncodeError> {
        let work = self.work;
        let shift = work.mean_shift(point.error);
        let outcome = self.trainer.variable(
            point.width,
            point.price(),
            (shift, work.threshold(point.error)),
            true,
            work.run,
        )?;
        let codewords: usize = outcome.books.iter().map(Book::size).sum();
        let count = outcome.books.len() as u32;
        // Blocks with codes lie together: about half the bricks that could hold one each do.
        let planes = f64::from(2 * 32 * (32 - count.leading_zeros()));
        let planes = bricks(work) * planes * (2.0 * outcome.open).min(1.0);
        let bits = self.mean_bits(shift)
            + outcome.code_bits
            + planes
            + fixed_bits(work, count, codewords as f64 * work.tables());
        Ok(Promise { bits, error: outcome.error })
    }

    /// The error at which a bit pays such that the target is met, for codes of one width.
    fn find(&self, mut point: Point) -> Result<(Point, Promise), EncodeError> {
        let work = self.work;
        let (by_error, target) = match work.options.target {
            Target::Psnr(psnr) => (true, work.error_of(psnr) / work.unit().powi(2)),
            _ => (false, most_bits(work)),
        };
        // Logarithm of the error at which a bit pays, and of what it leads to over what is wanted; both rise, or one
        // falls.
        let mut known: Vec<(f64, f64)> = Vec::new();
        let mut best: Option<(f64, Point, Promise)> = None;
        for _ in 0..TRIALS {
            let promise = self.trial(point)?;
            let off =
                ((if by_error { promise.error } else { promise.bits }).max(1e-9) / target.max(1e-9)).ln();
            if best.as_ref().is_none_or(|b| off.abs() < b.0.abs()) {
                best = Some((off, point, promise));
            }
            if off.abs() < 0.03 {
                break;
            }
            known.push((point.error.ln(), off));
            let next = match near_zero(&mut known) {
                Some(next) => next,
                None => point.error.ln() + if by_error { -off / 2.0 } else { off.clamp(-1.5, 1.5) },
            };
            point.error = next.clamp(-1.0, 12.0).exp();
        }
        best.map(|(_, point, promise)| (point, promise))
            .ok_or(EncodeError::Unsupported("no trial".to_owned()))
    }
}

/// Between the two known points nearest to zero on either side, where there are such.
fn near_zero(known: &mut [(f64, f64)]) -> Option<f64> {
    known.sort_by(|a, b| a.1.total_cmp(&b.1));
    let after = known.iter().position(|k| k.1 > 0.0)?;
    let (a, b) = (known.get(after.checked_sub(1)?)?, known.get(after)?);
    Some(a.0 + (b.0 - a.0) * (-a.1) / (b.1 - a.1))
}

/// Bits that there are for everything.
fn most_bits(work: &Work<'_>) -> f64 {
    match work.options.target {
        Target::Rate(rate) => rate * work.samples(),
        _ => f64::from(8 + CODE_BITS) * work.blocks() + fixed_bits(work, 0, 0.0),
    }
}

/// Bits of header, tables, codebooks and heads of bricks.
fn fixed_bits(work: &Work<'_>, books: u32, codewords: f64) -> f64 {
    let entries = codewords * VOXELS as f64 * f64::from(work.options.entry_bits);
    work.overhead(books) + entries + bricks(work) * f64::from(32 * HEAD_WORDS)
}

/// Bricks of all channels and frames.
fn bricks(work: &Work<'_>) -> f64 {
    let of_domain = |d: &Domain| {
        let bricks = d.size.map(|s| f64::from(s.div_ceil(BRICK))).iter().product::<f64>();
        bricks * d.blocks() as f64 / d.plane_blocks() as f64
    };
    work.domains().map(of_domain).sum()
}

/// Bits of the means of one plane, whose codes are finer by `shift` bits than what is stored.
fn mean_bits(plane: &Plane, size: [u32; 3], shift: u32) -> f64 {
    let bricks = size.map(|s| s.div_ceil(BRICK));
    let of_brick = |brick: [u32; 3]| {
        let first = brick.map(|b| b * BRICK);
        let cut = [0, 1, 2].map(|a| BRICK.min(size[a] - first[a]));
        let code = |p: [u32; 3]| {
            let mean = plane.means[number([0, 1, 2].map(|a| first[a] + p[a]), size)];
            (mean + (1 << shift >> 1)) >> shift
        };
        let (_, width) = mean_width(&positions(cut).map(code).collect::<Vec<_>>());
        f64::from(width * cut.iter().product::<u32>())
    };
    positions(bricks).map(of_brick).sum()
}

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

fn plan(work: &Work<'_>) -> Result<Point, EncodeError> {
    let domains: Vec<_> = work.domains().cloned().collect();
    let seed = work.options.seed;
    let sample = Sample::draw(work.source, &domains, work.quantiser, OVERVIEW, seed, work.run)?;
    let coder = work.coder(&[], 0, 0.0);
    let means = domains.iter().map(|domain| coder.code(work.source, domain, work.run));
    let means = means.collect::<Result<Vec<_>, _>>()?;
    let mut trainer = Trainer::new(&sample, work.training(true));
    trainer.copies = work.tables();
    let overview = Overview { work, trainer, means };
    let error = match work.options.target {
        Target::Psnr(psnr) => (work.error_of(psnr) / work.samples()).sqrt() / work.unit(),
        _ => 0.0126 * work.span / work.unit(),
    };
    let error = error.max(LEAST_ERROR);
    if work.options.index_bits > 0 {
        return Ok(overview.find(Point { width: work.options.index_bits, error })?.0);
    }
    // Widths that there are blocks for; the widest take too long on many blocks, and do not pay there.
    let blocks = work.blocks() / work.tables();
    let widest = ((blocks / 4.0).max(8.0).log2() as u32).min(if blocks > MANY { 8 } else { 12 });
    let first = ((blocks / 2000.0).max(1.0).log2().round() as u32).clamp(3, 6);
    let (mut point, promise) = overview.find(Point { width: first, error })?;
    let cost = |p: Promise| p.error + point.price() * p.bits;
    let mut costs = vec![(first, cost(promise))];
    let coarse = (first + 2..=widest).step_by(2).chain(first.checked_sub(1));
    for width in coarse {
        costs.push((width, cost(overview.trial(Point { width, ..point })?)));
    }
    let least = costs.iter().map(|c| c.1).fold(f64::INFINITY, f64::min);
    // Of those about as good the widest: fewer codes are fewer fetches.
    let good = costs.iter().filter(|c| c.1 <= ABOUT_AS_GOOD * least).map(|c| c.0);
    point.width = good.max().unwrap_or(first);
    if point.width.abs_diff(first) > 1 {
        point = overview.find(point)?.0;
    }
    Ok(point)
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
