//! The blocks of a frame coded with some codebooks: the best codes of each at every number of stages, and the ways to escape it.

use cvr_codebook::Quantiser;
use cvr_core::codec::{EncodeError, Progress};
use cvr_core::kit::{BlockRow, Measured, code_frame};
use cvr_core::volume::{BrickSource, FrameIndex};
use cvr_groups::{
    Candidate, CodedBlocks, Escape, KeptPlane, MOST_BITS, Prices, Rest, Scale, VOXELS, Ways, escape_bits,
};

use super::means::Means;
use crate::encode::beam::{About, Coder};
use crate::encode::to_sums;
use crate::stream::{TOP, block};
use cvr_core::kit::BlockGrid;

/// Part of a step of integers that escapes behind codes have at most where they are to lose nothing: codes leave values between
/// integers, which a whole step would round either way. Derived.
const COVERED: f64 = 0.95;
/// A block is followed until less than this part of the price of a code is left.
const ENOUGH: f64 = 0.5;

/// Everything that the coding of a block depends on.
#[derive(Debug)]
pub struct Coding<'a> {
    pub coder: Coder<'a>,
    pub means: Means,
    pub quantiser: Quantiser,
    /// Whether samples are integers.
    pub integers: bool,
    /// Bits of a code.
    pub width: u32,
    /// Squared error that a bit is worth at least, in data units.
    pub price: f64,
    /// No sample may be further from its value, in data units.
    pub bound: Option<f64>,
}

/// Coded blocks of a frame.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    means: Vec<u32>,
    /// Squared errors in data units, from no code on; infinite where the bound is not kept. And where those of each block end.
    errors: Vec<f32>,
    ends: Vec<usize>,
    /// Codes of one stage, of two, and so on. And where those of each block begin.
    codes: Vec<u16>,
    begins: Vec<usize>,
    ways: Ways,
}

/// A frame's blocks as the plan of what each keeps asks for them.
#[derive(Copy, Clone, Debug)]
pub struct Blocks<'a> {
    pub frame: &'a Frame,
    /// Codebooks.
    pub books: usize,
}

impl CodedBlocks for Blocks<'_> {
    fn books(&self) -> usize {
        self.books
    }

    fn mean(&self, block: usize) -> u32 {
        self.frame.means[block]
    }

    /// Further codes change nothing of a block that was not followed further.
    #[inline]
    fn error(&self, block: usize, codes: usize) -> f64 {
        let errors = self.frame.errors(block);
        errors[codes.min(errors.len() - 1)].into()
    }

    fn ways(&self, block: usize) -> &[Candidate] {
        self.frame.ways.of(block)
    }
}

impl Frame {
    fn errors(&self, block: usize) -> &[f32] {
        let begin = if block == 0 { 0 } else { self.ends[block - 1] };
        &self.errors[begin..self.ends[block]]
    }

    /// Code of the mean of a block.
    #[must_use]
    pub fn mean(&self, block: usize) -> u32 {
        self.means[block]
    }

    /// The best `count` codes of a block.
    #[must_use]
    pub fn codes(&self, block: usize, count: usize) -> &[u16] {
        let begin = self.begins[block] + count * count.saturating_sub(1) / 2;
        &self.codes[begin..begin + count]
    }

    fn append(&mut self, other: &Self) {
        let (errors, codes) = (self.errors.len(), self.codes.len());
        self.means.extend(&other.means);
        self.errors.extend(&other.errors);
        self.ends.extend(other.ends.iter().map(|end| errors + end));
        self.codes.extend(&other.codes);
        self.begins.extend(other.begins.iter().map(|begin| codes + begin));
        self.ways.append(&other.ways);
    }
}

/// The blocks of a row along x, in data units and in units of sums, and the values inside the volume of those that it cuts.
struct Row {
    samples: Vec<f32>,
    values: Vec<f32>,
    inside: Vec<Option<Vec<bool>>>,
    dimension: usize,
}

/// One block of a row.
#[derive(Copy, Clone)]
struct Block<'r> {
    samples: &'r [f32],
    values: &'r [f32],
    inside: Option<&'r [bool]>,
}

impl Row {
    fn read(
        coding: &Coding<'_>,
        source: &dyn BrickSource,
        at: (FrameIndex, u32, u32),
    ) -> Result<Self, EncodeError> {
        let row = BlockRow::read(source, block(0), at.0, at.1, at.2)?;
        let blocks = block(0).grid(source.layout().extent).x();
        let channels = coding.means.channels;
        let mut samples = Vec::new();
        (0..blocks).for_each(|bx| row.append(bx, &mut samples));
        let mut values = samples.clone();
        to_sums(coding.quantiser, 0, &mut values);
        let inside = |bx| cvr_codebook::blocks::inside(block(0), channels as u32, row.cut(bx));
        let inside = (0..blocks).map(|bx| Some(inside(bx)).filter(|all| !all.iter().all(|i| *i))).collect();
        Ok(Self { samples, values, inside, dimension: VOXELS * channels })
    }

    fn block(&self, n: usize) -> Block<'_> {
        let part = n * self.dimension..(n + 1) * self.dimension;
        Block {
            samples: &self.samples[part.clone()],
            values: &self.values[part],
            inside: self.inside[n].as_deref(),
        }
    }
}

impl Coding<'_> {
    /// Squared and largest error of values `c`, `c + step`, … of a block that decodes to some sums, in data units.
    fn error(&self, block: Block<'_>, sums: impl Fn(usize) -> i32, (c, step): (usize, usize)) -> (f64, f64) {
        let (mut squared, mut worst) = (0.0, 0.0_f64);
        for i in (c..block.samples.len()).step_by(step) {
            if block.inside.is_none_or(|inside| inside[i]) {
                let shown = self.quantiser.value(sums(i).clamp(0, TOP) as u32);
                let shown = if self.integers { shown.round() } else { shown };
                let error = f64::from(shown) - f64::from(block.samples[i]);
                squared += error * error;
                worst = worst.max(error.abs());
            }
        }
        (squared, worst)
    }

    /// The same of a whole block, as the plan takes it: infinite where the bound is not kept.
    fn counted(&self, block: Block<'_>, sums: impl Fn(usize) -> i32) -> f32 {
        let (squared, worst) = self.error(block, sums, (0, 1));
        if self.bound.is_some_and(|bound| worst > bound) { f32::INFINITY } else { squared as f32 }
    }

    /// What a block's mean and codes come to.
    fn sums(&self, mean: u32, codes: &[u16]) -> Vec<i32> {
        let base = self.means.decoded(mean);
        let mut sums: Vec<i32> =
            base.into_iter().take(self.means.channels).cycle().take(VOXELS * self.means.channels).collect();
        self.coder.add(codes, &mut sums);
        sums
    }

    /// The step at which an escape loses nothing of integers.
    fn exact(&self, codes: usize) -> Option<Scale> {
        let unit = 1.0 / f64::from(self.quantiser.step());
        let part = if codes == 0 { 1.0 } else { COVERED };
        (self.integers && unit >= 1.0).then(|| Scale::at_most(part * unit))
    }

    /// The parts of an escape in so many bits of what some sums leave, and the squared error then.
    fn escape(&self, block: Block<'_>, sums: &[i32], codes: usize, bits: u32) -> (Vec<Escape>, f32) {
        let channels = self.means.channels;
        let (mut parts, mut all, mut worst) = (Vec::new(), 0.0, 0.0_f64);
        for c in 0..channels {
            // Voxels outside the volume are part of the means at coarser resolutions.
            let left: Vec<f32> =
                (c..sums.len()).step_by(channels).map(|i| block.values[i] - sums[i] as f32).collect();
            let rest = Rest::of(&left, &[true; VOXELS]);
            let error = |escape: &Escape| {
                let shown = |i: usize| sums[i] + escape.value(i / channels);
                self.error(block, shown, (c, channels))
            };
            let escape = match self.bound {
                None => rest.nearest(bits, self.exact(codes), |escape| error(escape).0 as f32).0,
                Some(bound) => {
                    let step =
                        Scale::at_most((1.999 * bound / f64::from(self.quantiser.step()) - 1.0).max(1.0));
                    let exact = self.exact(codes).and_then(|exact| rest.covering(bits, exact));
                    let fine = exact.filter(|exact| error(exact).1 <= bound);
                    fine.or_else(|| rest.covering(bits, step)).unwrap_or_else(|| rest.fit(bits))
                }
            };
            let (squared, of_channel) = error(&escape);
            all += squared;
            worst = worst.max(of_channel);
            parts.push(escape);
        }
        let kept = self.bound.is_none_or(|bound| worst <= bound);
        (parts, if kept { all as f32 } else { f32::INFINITY })
    }

    fn ways(&self, block: Block<'_>, mean: u32, of: &Frame, ways: &mut Vec<Candidate>) {
        let number = of.ends.len() - 1;
        let errors = of.errors(number);
        let behind = |count: usize| {
            let sums = self.sums(mean, of.codes(number, count));
            move |bits| self.escape(block, &sums, count, bits).1
        };
        if self.bound.is_none() {
            let prices =
                Prices { bit: self.price, width: self.width.into(), parts: self.means.channels as u32 };
            return prices.ways(errors, behind, |candidate| ways.push(candidate));
        }
        // With a bound bits alone count: the fewest behind the mean alone, and behind each number of codes that do not keep it.
        let mut least = u32::MAX;
        for (count, error) in errors.iter().enumerate() {
            let bits_of_codes = self.width * count as u32;
            if error.is_finite() || bits_of_codes >= least {
                break;
            }
            let escape = behind(count);
            let found = (1..=MOST_BITS).map(|bits| (bits, escape(bits))).find(|(_, error)| error.is_finite());
            if let Some((bits, error)) = found {
                let taken = bits_of_codes + escape_bits(bits, self.means.channels as u32);
                if taken < least {
                    least = taken;
                    ways.push(Candidate { codes: count as u8, bits: bits as u8, error });
                }
            }
        }
    }

    fn code_row(&self, row: &Row) -> Frame {
        let count = row.samples.len() / row.dimension;
        let mut rows = row.values.clone();
        let mut means = Vec::with_capacity(count);
        for (n, values) in rows.chunks_exact_mut(row.dimension).enumerate() {
            let code = self.means.code(values, row.inside[n].as_deref());
            let base = self.means.decoded(code);
            values.iter_mut().enumerate().for_each(|(i, v)| *v -= base[i % self.means.channels] as f32);
            means.push(code);
        }
        let start = |n: usize| {
            vec![self.counted(row.block(n), |i| self.means.decoded(means[n])[i % self.means.channels])]
        };
        let mut errors: Vec<Vec<f32>> = (0..count).map(start).collect();
        let mut codes: Vec<Vec<u16>> = vec![Vec::new(); count];
        // A block that its mean alone suffices for is not followed at all.
        let enough = ENOUGH * self.price * f64::from(self.width);
        let open: Vec<usize> = (0..count).filter(|n| f64::from(errors[*n][0]) > enough).collect();
        let followed: Vec<f32> =
            open.iter().flat_map(|n| &rows[n * row.dimension..(n + 1) * row.dimension]).copied().collect();
        let about = |k: usize| About {
            inside: row.inside[open[k]].as_deref(),
            base: self.means.decoded(means[open[k]]),
        };
        let in_sums = enough / f64::from(self.quantiser.step()).powi(2);
        self.coder.follow(&followed, about, in_sums, |best| {
            let n = open[best.block];
            let sums = self.sums(means[n], best.codes);
            errors[n].push(self.counted(row.block(n), |i| sums[i]));
            codes[n].extend(best.codes);
        });
        let mut all = Frame { means, ..Frame::default() };
        for n in 0..count {
            all.begins.push(all.codes.len());
            all.codes.extend(&codes[n]);
            all.errors.extend(&errors[n]);
            all.ends.push(all.errors.len());
            let mut ways = Vec::new();
            self.ways(row.block(n), all.means[n], &all, &mut ways);
            all.ways.push(ways);
        }
        all
    }

    /// Codes the blocks of a frame.
    ///
    /// # Errors
    /// Those of reading, and when `run` was cancelled.
    pub fn code(
        &self,
        source: &dyn BrickSource,
        grid: &BlockGrid,
        frame: FrameIndex,
        run: &Progress<'_>,
    ) -> Result<Frame, EncodeError> {
        let mut all = Frame::default();
        let row = |by, bz| Ok(self.code_row(&Row::read(self, source, (frame, by, bz))?));
        code_frame(grid, 1, run, row, |rows| {
            rows.iter().for_each(|row| all.append(row));
            Ok(())
        })?;
        Ok(all)
    }

    /// The words of the escapes that `kept` chose, and what all samples come to.
    ///
    /// # Errors
    /// Those of reading, and when `run` was cancelled.
    pub fn finish(
        &self,
        (source, grid): (&dyn BrickSource, &BlockGrid),
        frame: FrameIndex,
        (coded, kept): (&Frame, &mut KeptPlane),
        run: &Progress<'_>,
    ) -> Result<Measured, EncodeError> {
        let blocks = grid.blocks();
        let mut measured = Measured::NOTHING;
        let (mut words, mut ends) = (Vec::new(), Vec::new());
        let chosen: &KeptPlane = kept;
        let row = |by: u32, bz: u32| {
            let row = Row::read(self, source, (frame, by, bz))?;
            let first = (bz * blocks.y() + by) as usize * blocks.x() as usize;
            let (mut words, mut ends, mut measured) = (Vec::new(), Vec::new(), Measured::NOTHING);
            for n in 0..blocks.x() as usize {
                let (number, block) = (first + n, row.block(n));
                let (count, bits) = (usize::from(chosen.codes[number]), chosen.bits[number]);
                let mut sums = self.sums(coded.mean(number), coded.codes(number, count));
                if bits > 0 {
                    let parts = self.escape(block, &sums, count, bits.into()).0;
                    for (i, sum) in sums.iter_mut().enumerate() {
                        *sum += parts[i % parts.len()].value(i / parts.len());
                    }
                    parts.iter().for_each(|part| part.write(&mut words));
                }
                ends.push(words.len());
                for (i, sample) in block.samples.iter().enumerate() {
                    if block.inside.is_none_or(|inside| inside[i]) {
                        let value = self.quantiser.value(sums[i].clamp(0, TOP) as u32);
                        measured.add(*sample, value, self.integers);
                    }
                }
            }
            Ok((words, ends, measured))
        };
        code_frame(grid, 1, run, row, |rows| {
            for (of_row, ends_of_row, of) in rows {
                let begun = words.len();
                words.extend(of_row);
                ends.extend(ends_of_row.into_iter().map(|end| begun + end));
                measured = measured.and(of);
            }
            Ok(())
        })?;
        (kept.words, kept.ends) = (words, ends);
        Ok(measured)
    }
}
