//! The payload `variable`: a mean for each block, as many codes as pay, and what is left of busy blocks coded directly.
//!
//! A price of a bit decides everything (Shoham and Gersho 1988): which codebooks there are, how many codes a block keeps, and
//! whether it is escaped. Trials on a few blocks find the price; codebooks are made for it; all blocks are coded; and the price at
//! which they meet the target exactly is found on these codes.

mod coding;
mod grow;
mod means;
mod search;
mod write;

use cvr_codebook::{Quantiser, Vectors};
use cvr_core::codec::{Cancelled, EncodeError, EncodeReport, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::kit::BlockGrid;
use cvr_core::volume::{BrickSource, FrameIndex, ValueRange, VolumeLayout};
use cvr_groups::{Aim, Expected, HEAD_WORDS, Plan, Plane, Settled, Sum, settle};
use rayon::prelude::*;

use super::beam::{About, Coder};
use super::stage::Stage;
use super::{RvqEncoder, refine, to_sums};
use crate::settings::{Options, Target};
use crate::stream::{Entries, block};
use coding::{Blocks, Coding, Frame};
use grow::{Sample, Wanted, energy, grow, kept_codes, residuals};
use means::Means;
use search::{Point, Trials, few};
use write::{Written, write};

/// The container's header is a multiple of this many bytes. Given by the container's format.
const HEADER_BYTES: f64 = 2048.0;
/// Used bytes of the header: at least, per frame, and per table, as in typical headers.
const HEADER_USED: [f64; 3] = [1500.0, 9.0, 170.0];
/// Root mean square error over max − min that the search begins with: 38 dB. It affects the search's length, not its end.
const BEGIN: f64 = 0.0126;
/// Codebooks are made anew if the logarithm of the error at which a bit pays lies outside of this, at most so often. Those made for
/// a higher price serve a lower one well: they are for the worst blocks. Limit.
const OFF: [f64; 2] = [-0.7, 0.35];
/// Blocks of joint training, at most. Limit.
const JOINT_BLOCKS: usize = 49152;
const TRIES: usize = 3;
/// Escapes are sought, and blocks followed, that may pay at this part of the price that is expected; if that turns out to be too
/// dear, at the next. Limit.
const FLOORS: [f64; 4] = [0.5, 0.1, 0.01, 0.0];
/// The largest change of the logarithm of the error from one attempt to the next.
const FARTHEST: f64 = 1.0;

/// Everything that all steps need.
struct Work<'a> {
    source: &'a dyn BrickSource,
    run: &'a Progress<'a>,
    options: Options,
    layout: VolumeLayout,
    quantiser: Quantiser,
    grid: BlockGrid,
    entries: Entries,
    aim: Aim,
    bound: Option<f64>,
}

/// A table, and its frames coded with it.
struct Coded {
    stages: Vec<Stage>,
    means: Means,
    frames: Vec<Frame>,
    /// Blocks and rounds of the training.
    blocks: u64,
    rounds: u32,
}

/// All tables, and what meets the aim.
struct Attempt {
    tables: Vec<Coded>,
    settled: Settled,
    width: u32,
}

impl Work<'_> {
    fn samples(&self) -> f64 {
        self.layout.samples() as f64
    }

    fn unit(&self) -> f64 {
        self.quantiser.step().into()
    }

    fn expected(&self) -> Expected {
        let unit = self.layout.sample.is_integer().then(|| 1.0 / self.unit());
        Expected::of(unit, self.layout.channels)
    }

    /// Bits of everything but groups, with codebooks of so many codewords of so many bits.
    fn fixed_bits(&self, codewords: f64, codeword_bits: f64) -> f64 {
        let groups = self.grid.blocks().to_array().map(|b| f64::from(b.div_ceil(cvr_groups::EDGE)));
        let heads = groups.iter().product::<f64>() * f64::from(32 * HEAD_WORDS * self.layout.frames);
        let (frames, tables) = (
            f64::from(self.layout.frames),
            if self.options.training.per_frame { f64::from(self.layout.frames) } else { 1.0 },
        );
        let [used, per_frame, per_table] = HEADER_USED;
        let header = HEADER_BYTES * ((used + per_frame * frames + per_table * tables) / HEADER_BYTES).ceil();
        // A word after each frame, and the partly used last word of each table's codebooks.
        let ends = 64.0 * frames + 32.0 * tables;
        8.0 * header + ends + heads + codewords * codeword_bits
    }
}

/// Encodes a volume.
///
/// # Errors
/// Those of reading and writing, when `run` was cancelled, and where a bound on the error cannot be kept.
pub fn encode(
    encoder: &RvqEncoder,
    (source, out, run): (&dyn BrickSource, &mut dyn StreamWriter, &Progress<'_>),
    (quantiser, range): (Quantiser, ValueRange),
    entries: Entries,
) -> Result<EncodeReport, EncodeError> {
    let (layout, options) = (source.layout().clone(), encoder.options);
    let span = f64::from(range.max) - f64::from(range.min);
    let integers = layout.sample.is_integer();
    let samples = layout.samples() as f64;
    let (aim, bound) = match options.target {
        Target::Rate(rate) => (Aim::Bits(rate * samples), None),
        Target::Psnr(psnr) => {
            let root = span * 10.0_f64.powf(-psnr / 20.0);
            (Aim::Error(root * root * samples), None)
        }
        Target::MaxError(most) => (Aim::Error(f64::MAX), Some(if integers { most.floor() } else { most })),
    };
    let grid = BlockGrid::new(block(0), layout.extent);
    let work = Work { source, run, options, layout, quantiser, grid, entries, aim, bound };
    let Attempt { mut tables, settled, width } = best_attempt(&work, span)?;
    let plan = work.plan(&tables);
    let (kept, sum) = plan.kept(aim, &settled);
    drop(plan);
    for table in &mut tables {
        table.stages.truncate(settled.books.max(1));
        if settled.books == 0 {
            table.stages = vec![Stage::zero(table.stages[0].codebook.dimension(), entries)];
        }
    }
    let report = write(encoder, &work, Written { tables, kept, width }, out)?;
    if let Some(bound) = bound.filter(|bound| report.error_bound.is_some_and(|error| error > *bound)) {
        return Err(EncodeError::Unsupported(format!(
            "no escape keeps errors within {bound} for a volume that spans {span}; ask for a larger `max_error`"
        )));
    }
    Ok(EncodeReport { notes: notes(&work, sum, span), ..report })
}

/// What a user should know of a target that was missed.
fn notes(work: &Work<'_>, sum: Sum, span: f64) -> Vec<String> {
    let rate = sum.bits / work.samples();
    let psnr = 10.0 * (span * span * work.samples() / sum.error.max(1e-300)).log10();
    match work.options.target {
        Target::Rate(most) if rate > most => vec![format!(
            "about {rate:.3} bits per sample where {most} were asked for: means, heads and header take more"
        )],
        Target::Psnr(asked) if !work.aim.met(sum) => {
            vec![format!("{psnr:.2} dB where {asked} were asked for: escapes of 16 bits do not reach it")]
        }
        _ => Vec::new(),
    }
}

/// Codes with the best codebooks that a few attempts find.
fn best_attempt(work: &Work<'_>, span: f64) -> Result<Attempt, EncodeError> {
    let options = work.options;
    let mut samples = Vec::new();
    for (frames, seed) in options.training.served(work.layout.frames).into_iter().zip(options.training.seed..)
    {
        let blocks = work.grid.blocks().voxels() as f64 * f64::from(frames.end - frames.start);
        let (draw, count) = (options.training.draw, options.training.training_blocks);
        let mut vectors = draw.vectors(work.source, block(0), frames, count, seed, work.run)?;
        to_sums(work.quantiser, 0, vectors.values_mut());
        let scale = blocks / vectors.total_weight().max(1e-300);
        samples.push(Sample { vectors, scale });
    }
    let mut point = first_point(work, &samples, span)?;
    let mut found: Option<Attempt> = None;
    for _ in 0..TRIES {
        let attempt = attempt(work, &samples, point)?;
        let (sum, price) = (attempt.settled.sum, attempt.settled.price / work.unit().powi(2));
        let better = found.as_ref().is_none_or(|best| work.aim.order(sum, best.settled.sum).is_lt());
        if better {
            found = Some(attempt);
        }
        let off = (point.of_price(price.max(1e-9)).error / point.error).ln();
        // With a bound the price follows from it, and codes keep it at any price.
        if work.bound.is_some() || (OFF[0]..OFF[1]).contains(&off) {
            break;
        }
        point.error = (point.error * off.clamp(-FARTHEST, FARTHEST).exp()).max(0.05);
    }
    found.ok_or_else(|| EncodeError::Unsupported("no blocks".to_owned()))
}

/// What codebooks are grown for, but for size, price and means.
fn wanted(work: &Work<'_>) -> Wanted {
    Wanted {
        size: 0,
        stages: work.options.stages,
        price: 0.0,
        means: Means { channels: work.layout.channels as usize, shift: 0 },
        entries: work.entries,
        expected: work.expected(),
        all_train: false,
    }
}

/// Price and width to begin with.
fn first_point(work: &Work<'_>, samples: &[Sample], span: f64) -> Result<Point, Cancelled> {
    let of_first = few(&samples[0]);
    // One table stands for all.
    let scale = of_first.scale * samples.len() as f64;
    let in_sums = match work.aim {
        Aim::Error(most) => Aim::Error(most / work.unit().powi(2)),
        bits @ Aim::Bits(_) => bits,
    };
    let trials = Trials {
        held_out: of_first.scale > 1.5 || of_first.vectors.len() < samples[0].vectors.len(),
        sample: Sample { scale, ..of_first },
        training: &work.options.training,
        wanted: wanted(work),
        size: work.options.codewords.map(|size| size as usize),
        aim: in_sums,
        fixed: work.fixed_bits(0.0, 0.0),
        run: work.run,
    };
    let begin = match (work.bound, work.options.target) {
        // Errors of an escape are about evenly spread within the bound.
        (Some(bound), _) => {
            let error = (bound.max(0.5) / work.unit() / 3.0_f64.sqrt()).max(0.05);
            return trials.at_error(error);
        }
        (_, Target::Psnr(psnr)) => span * 10.0_f64.powf(-psnr / 20.0) / work.unit(),
        _ => BEGIN * span / work.unit(),
    };
    trials.search(begin.max(0.05))
}

/// Codebooks made for a point, all blocks coded with them, and the price that meets the aim.
fn attempt(work: &Work<'_>, samples: &[Sample], point: Point) -> Result<Attempt, EncodeError> {
    let size = work.options.codewords.map_or(1_usize << point.width, |size| size as usize);
    let means = Means::fine_enough(work.layout.channels as usize, point.error);
    let wanted = Wanted { size, price: point.price(), means, all_train: point.all_train, ..wanted(work) };
    let mut tables = Vec::new();
    for sample in samples {
        let mut stages = grow(sample, &wanted, &work.options.training, false, work.run)?.stages;
        let rounds = refined(work, sample, &wanted, &mut stages)?;
        tables.push(Coded { stages, means, frames: Vec::new(), blocks: sample.vectors.len() as u64, rounds });
    }
    // Tables of a stream have one number of codebooks.
    let most = tables.iter().map(|t| t.stages.len()).max().unwrap_or(0).max(1);
    let dimension = samples[0].vectors.dimension();
    for table in &mut tables {
        table.stages.resize_with(most, || Stage::zero(dimension, work.entries));
    }
    let about = point.price() * work.unit().powi(2);
    let mut floor = FLOORS[0];
    for lower in FLOORS {
        floor = lower;
        work.code(&mut tables, wanted.width(), floor * about)?;
        // With a bound any price is met, and the lowest number of bits is wanted.
        let about = if work.bound.is_some() { 1e-3 } else { 1.0 } * about;
        let plan = work.plan(&tables);
        let settled = settle(work.aim, about, |price| plan.sums(price));
        drop(plan);
        // At a lower price more escapes may pay, and the price is then higher than what was found without them.
        if work.bound.is_some() || settled.price >= floor * about || floor == 0.0 {
            return Ok(Attempt { tables, settled, width: wanted.width() });
        }
    }
    Err(EncodeError::Unsupported(format!("no price of a bit from {floor} of {about} on")))
}

/// Joint training of all codebooks on the blocks that codes suffice for, with the codes that pay; the rounds that gained.
fn refined(
    work: &Work<'_>,
    sample: &Sample,
    wanted: &Wanted,
    stages: &mut Vec<Stage>,
) -> Result<u32, EncodeError> {
    if work.options.refinement == 0 || stages.len() < 2 {
        return Ok(0);
    }
    let left = residuals(&sample.vectors, wanted.means);
    let code_price = wanted.price * f64::from(wanted.width());
    let mut vectors = Vectors::new(left.dimension());
    let open: Vec<usize> = (0..left.len()).filter(|i| energy(left.vector(*i)) > code_price).collect();
    let every = open.len().div_ceil(JOINT_BLOCKS).max(1);
    open.iter().step_by(every).for_each(|i| vectors.push(left.vector(*i), left.weight(*i)));
    if vectors.is_empty() {
        return Ok(0);
    }
    let beam = work.options.beam;
    // Blocks that are better coded directly train nothing.
    let mut taught = Vectors::new(left.dimension());
    for (i, (_, error)) in codes_that_pay(&vectors, stages, beam, code_price).iter().enumerate() {
        if wanted.trains(*error) {
            taught.push(vectors.vector(i), vectors.weight(i));
        }
    }
    if taught.is_empty() {
        return Ok(0);
    }
    let rounds =
        refine::jointly(&taught, stages, work.entries, (work.options.refinement, 0), work.run, |stages| {
            codes_that_pay(&taught, stages, beam, code_price).into_iter().flat_map(|block| block.0).collect()
        })?;
    Ok(rounds)
}

/// By block: the codes that pay, code 0 where a block keeps none, and the squared error then.
fn codes_that_pay(vectors: &Vectors, stages: &[Stage], beam: usize, code_price: f64) -> Vec<(Vec<u32>, f64)> {
    let coder = Coder::new(stages, beam);
    let dimension = vectors.dimension();
    // Values count from the means here. The search therefore clamps few of them where the decoder would: at the ends of the range.
    let about = About::WHOLE;
    let of_part = |rows: &[f32]| {
        let mut paths: Vec<Vec<(f64, Vec<u16>)>> =
            rows.chunks_exact(dimension).map(|row| vec![(energy(row), Vec::new())]).collect();
        coder.follow(
            rows,
            |_| about,
            0.5 * code_price,
            |best| {
                paths[best.block].push((best.error, best.codes.to_vec()));
            },
        );
        let of_block = |paths: &Vec<(f64, Vec<u16>)>| kept_codes(paths, stages.len(), code_price);
        paths.iter().map(of_block).collect::<Vec<_>>()
    };
    vectors.values().par_chunks(64 * dimension).flat_map_iter(of_part).collect()
}

impl Work<'_> {
    /// Codes all blocks with the codebooks of their tables.
    fn code(&self, tables: &mut [Coded], width: u32, price: f64) -> Result<(), EncodeError> {
        for (table, frames) in tables.iter_mut().zip(self.options.training.served(self.layout.frames)) {
            let coding = self.coding(&table.stages, table.means, width, price);
            let coded = frames.map(|frame| coding.code(self.source, &self.grid, FrameIndex(frame), self.run));
            let coded = coded.collect::<Result<Vec<_>, _>>()?;
            drop(coding);
            table.frames = coded;
        }
        Ok(())
    }

    fn coding<'s>(&self, stages: &'s [Stage], means: Means, width: u32, price: f64) -> Coding<'s> {
        Coding {
            coder: Coder::new(stages, self.options.beam),
            means,
            quantiser: self.quantiser,
            integers: self.layout.sample.is_integer(),
            width,
            price,
            bound: self.bound,
        }
    }

    /// The groups of all frames.
    fn plan<'t>(&self, tables: &'t [Coded]) -> Plan<Blocks<'t>> {
        let size = self.grid.blocks().to_array();
        let of_table = |(table, coded): (usize, &'t Coded)| {
            let books = coded.stages.len();
            let placed = move |(number, frame): (usize, &'t Frame)| Plane {
                blocks: Blocks { frame, books },
                size,
                table,
                number,
            };
            coded.frames.iter().enumerate().map(placed)
        };
        let planes = tables.iter().enumerate().flat_map(of_table);
        let most = tables.iter().map(|t| t.stages.len()).max().unwrap_or(0);
        let codeword_bits = wanted(self).codeword_bits();
        // Codebooks of a stream lie as far apart as the largest needs. One of the zero vector stands for none.
        let largest = |m: usize| {
            let sizes = tables.iter().flat_map(|t| t.stages.iter().take(m));
            sizes.map(|stage| stage.codebook.size()).max().unwrap_or(1)
        };
        let codewords = |m: usize| (largest(m) * m.max(1) * tables.len()) as f64;
        let fixed = (0..=most).map(|m| self.fixed_bits(codewords(m), codeword_bits)).collect();
        let widths = (0..=most).map(|m| cvr_codebook::index_bits(largest(m))).collect();
        let widths = vec![widths; tables.len()];
        Plan::new(planes, fixed, widths, self.layout.channels)
    }
}
