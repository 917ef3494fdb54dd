//! The encoder: trains codebooks on some of the blocks, then codes mean and indices of every block.

use cvr_codebook::blocks::{cuts, inside};
use cvr_codebook::pack::BitPacker;
use cvr_codebook::settings::TrainingSettings;
use cvr_codebook::{Codebook, Search, sample};
use cvr_core::codec::{EncodeError, EncodeReport, Encoder, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::kit::{BlockRow, code_frame, value_range};
use cvr_core::volume::{BrickSource, FrameIndex};

use crate::blocks::{Levels, Means, sub_block_of};
use crate::geometry::{Geometry, Parameters, TrainingRecord, VOXELS, block};
use crate::training::{Tables, Trainer};
use crate::{CODEBOOK, INDEX};

/// Encodes with one set of settings.
#[derive(Debug)]
pub struct HvqEncoder {
    /// Sizes of the coarse and of the detail codebook.
    pub codewords: [u32; 2],
    /// Bits of a mean. `None`: those of the samples.
    pub mean_bits: Option<u32>,
    pub codeword_bits: u32,
    pub training: TrainingSettings,
}

impl Encoder for HvqEncoder {
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let layout = source.layout().clone();
        let range = value_range(source, block(), run)?;
        let levels = Levels::over(range, layout.sample, self.mean_bits, self.codeword_bits)
            .map_err(EncodeError::Unsupported)?;
        let with = self.training;
        let trainer = Trainer {
            codewords: self.codewords,
            codeword_bits: self.codeword_bits,
            with,
            source,
            levels,
            served: with.served(layout.frames),
            run,
        };
        let ([coarse, detail], blocks) = trainer.tables()?;
        let parameters = Parameters {
            grid: block().grid(layout.extent).to_array(),
            level_bits: levels.quantiser.bits(),
            top: levels.top,
            offset: levels.quantiser.offset(),
            step: levels.quantiser.step(),
            mean_bits: levels.mean_bits,
            mean_step: levels.mean_step,
            codeword_bits: self.codeword_bits,
            coarse: coarse.parameters.clone(),
            detail: detail.parameters.clone(),
            training: TrainingRecord {
                initial: with.initial.name().to_owned(),
                generator: sample::GENERATOR.to_owned(),
                seed: with.seed,
                blocks,
                coarse: coarse.record.clone(),
                detail: detail.record.clone(),
            },
        };
        let Some(geometry) = Geometry::new(&layout, &parameters) else {
            let problem = "the volume asks for more than a stream of this codec can say".to_owned();
            return Err(EncodeError::Unsupported(problem));
        };
        for (coarse, detail) in coarse.codebooks.iter().zip(&detail.codebooks) {
            for (table, words) in [(coarse, geometry.coarse.words), (detail, geometry.detail.words)] {
                let mut packed = table.packed();
                packed.resize(words as usize, 0);
                out.append_words(CODEBOOK, &packed)?;
            }
        }
        let mut error_bound = 0.0_f64;
        for frame in (0..layout.frames).map(FrameIndex) {
            let table = geometry.table_of(frame.0);
            let tables = [&coarse.codebooks[table], &detail.codebooks[table]];
            let coder = Coder::new(&geometry, levels, tables, layout.sample.is_integer());
            error_bound = error_bound.max(coder.frame(source, frame, out, run)?);
        }
        out.shape(CODEBOOK, &geometry.codebook_shape())?;
        out.shape(INDEX, &geometry.index_shape(layout.frames))?;
        out.parameters_of(&parameters)?;
        Ok(EncodeReport { error_bound: Some(error_bound), notes: self.notes([&coarse, &detail]) })
    }
}

impl HvqEncoder {
    fn notes(&self, stages: [&Tables; 2]) -> Vec<String> {
        let stages = ["coarse", "detail"].into_iter().zip(stages).zip(self.codewords);
        stages
            .filter_map(|((name, tables), asked)| {
                let fewest = tables.parameters.tables.iter().copied().min().filter(|size| *size < asked)?;
                Some(format!(
                    "{fewest} {name} codewords serve where {asked} were asked for: the training blocks tell no more apart"
                ))
            })
            .collect()
    }
}

/// Codes of some blocks, one after another, and the largest error of a voxel.
#[derive(Default)]
struct Codes {
    means: Vec<u32>,
    coarse: Vec<u32>,
    detail: Vec<u32>,
    worst: f64,
}

/// A way in which the volume's border cuts blocks.
struct Cut<'a> {
    /// Size of a block in voxels, after the border cuts it.
    size: [usize; 3],
    /// Which values of a block lie in the volume.
    exists: Vec<bool>,
    /// Whether all do.
    whole: bool,
    detail: Search<'a>,
}

/// Codes the blocks of a frame.
struct Coder<'a> {
    geometry: &'a Geometry,
    levels: Levels,
    tables: [&'a Codebook; 2],
    integers: bool,
    coarse: Search<'a>,
    cuts: Vec<Cut<'a>>,
}

impl<'a> Coder<'a> {
    fn new(geometry: &'a Geometry, levels: Levels, tables: [&'a Codebook; 2], integers: bool) -> Self {
        let [coarse, detail] = tables;
        let of_cut = |size| {
            let exists = inside(block(), geometry.channels, size);
            let whole = exists.iter().all(|exists| *exists);
            let detail = Search::new(detail, (!whole).then_some(&exists[..]));
            Cut { size, exists, whole, detail }
        };
        let cuts = cuts(block(), geometry.grid.volume()).into_iter().map(of_cut).collect();
        Self { geometry, levels, tables, integers, coarse: Search::new(coarse, None), cuts }
    }

    /// Appends means and indices of a frame, which are held in memory until then. Returns the largest error of a voxel,
    /// integers rounded.
    fn frame(
        &self,
        source: &dyn BrickSource,
        frame: FrameIndex,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<f64, EncodeError> {
        let g = self.geometry;
        let mut planes = [g.means, g.coarse.plane, g.detail.plane]
            .map(|plane| (BitPacker::new(plane.bits), Vec::with_capacity(plane.words as usize)));
        let mut worst = 0.0_f64;
        let row = |by, bz| Ok(self.row(&BlockRow::read(source, block(), frame, by, bz)?));
        code_frame(&g.grid, 1, run, row, |rows| {
            for Codes { means, coarse, detail, worst: error } in rows {
                for ((packer, words), numbers) in planes.iter_mut().zip([means, coarse, detail]) {
                    numbers.into_iter().for_each(|number| packer.push(number, words));
                }
                worst = worst.max(error);
            }
            Ok(())
        })?;
        for (packer, words) in &mut planes {
            packer.flush(words);
            out.append_words(INDEX, words)?;
        }
        Ok(worst)
    }

    /// The codes of a row of blocks.
    fn row(&self, row: &BlockRow) -> Codes {
        let blocks = self.geometry.grid.blocks().x();
        let whole = if row.cut(blocks - 1) == row.cut(0) { blocks } else { blocks - 1 };
        let mut codes = Codes::default();
        for part in [0..whole, whole..blocks] {
            let Some(size) = part.clone().next().map(|bx| row.cut(bx)) else { continue };
            let Some(cut) = self.cuts.iter().find(|cut| cut.size == size) else { continue };
            let mut values = Vec::with_capacity(part.len() * cut.exists.len());
            part.for_each(|bx| row.append(bx, &mut values));
            self.blocks(&values, cut, &mut codes);
        }
        codes
    }

    /// Appends the codes of blocks that the border cuts alike.
    fn blocks(&self, values: &[f32], cut: &Cut<'_>, codes: &mut Codes) {
        let [coarse, detail] = self.tables;
        let dimension = cut.exists.len();
        let channels = dimension / VOXELS as usize;
        let levels: Vec<f32> = values.iter().map(|v| self.levels.of(*v)).collect();
        // The sum of the stages so far, for every value.
        let mut sums = Vec::with_capacity(values.len());
        let (mut differences, mut counts) = (Vec::new(), Vec::new());
        for levels in levels.chunks_exact(dimension) {
            let means = Means::of(levels, |voxel| cut.exists[voxel * channels]);
            let own: Vec<u32> = means.block.iter().map(|mean| self.levels.mean_code(*mean)).collect();
            let added = own.iter().map(|code| (code * self.levels.mean_step) as i32);
            let pairs = means.sub_blocks.iter().zip(added.clone().cycle());
            differences.extend(pairs.map(|(sub, mean)| (sub - f64::from(mean)) as f32));
            sums.extend(added.cycle().take(dimension));
            counts.push(means.counts);
            codes.means.extend(own);
        }
        let nearest = if cut.whole {
            self.coarse.rows(&differences).into_iter().map(|n| n.index).collect()
        } else {
            let rows = differences.chunks_exact(coarse.dimension()).zip(&counts);
            rows.map(|(row, counts)| nearest_weighted(coarse, row, counts)).collect::<Vec<u32>>()
        };
        let parts = || values.chunks_exact(dimension);
        for ((values, sums), index) in parts().zip(sums.chunks_exact_mut(dimension)).zip(nearest) {
            let added = coarse.codeword(index as usize);
            let of = |i: usize| added[sub_block_of(i / channels) * channels + i % channels] as i32;
            codes.coarse.push(if self.add(values, &cut.exists, sums, of) { index } else { 0 });
        }
        let left: Vec<f32> = levels.iter().zip(&sums).map(|(level, sum)| level - *sum as f32).collect();
        let nearest = cut.detail.rows(&left);
        for ((values, sums), nearest) in parts().zip(sums.chunks_exact_mut(dimension)).zip(nearest) {
            let added = detail.codeword(nearest.index as usize);
            let better = self.add(values, &cut.exists, sums, |i| added[i] as i32);
            codes.detail.push(if better { nearest.index } else { 0 });
            for ((value, sum), _) in values.iter().zip(&*sums).zip(&cut.exists).filter(|(_, exists)| **exists)
            {
                let shown = self.levels.value(*sum);
                let shown = if self.integers { shown.round() } else { shown };
                codes.worst = codes.worst.max((f64::from(shown) - f64::from(*value)).abs());
            }
        }
    }

    /// Adds a codeword, unless the decoded block would then be less accurate. If values are rounded or clamped, the
    /// nearest codeword in levels need not be the best. Returns whether it was added.
    fn add(&self, values: &[f32], exists: &[bool], sums: &mut [i32], added: impl Fn(usize) -> i32) -> bool {
        let error = |with: &dyn Fn(usize) -> i32| -> f64 {
            let kept = values.iter().enumerate().filter(|(i, _)| exists[*i]);
            let off = |(i, v): (usize, &f32)| f64::from(self.levels.value(sums[i] + with(i))) - f64::from(*v);
            kept.map(off).map(|off| off * off).sum()
        };
        let better = error(&added) <= error(&|_| 0);
        if better {
            sums.iter_mut().enumerate().for_each(|(i, sum)| *sum += added(i));
        }
        better
    }
}

/// The codeword nearest to the means of sub-blocks. Each mean counts as many times as its sub-block has voxels. The
/// first of equally near ones.
fn nearest_weighted(codebook: &Codebook, row: &[f32], counts: &[u32]) -> u32 {
    let channels = row.len() / counts.len();
    let mut best = (0, f64::INFINITY);
    for k in 0..codebook.size() {
        let terms = row.iter().zip(codebook.codeword(k)).enumerate();
        let distance: f64 = terms
            .map(|(i, (v, c))| f64::from(counts[i / channels]) * (f64::from(*v) - f64::from(*c)).powi(2))
            .sum();
        if distance < best.1 {
            best = (k as u32, distance);
        }
    }
    best.0
}
