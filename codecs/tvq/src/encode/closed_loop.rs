//! The codes of all blocks of a domain, in closed loop: each codebook codes the remaining error of the decoder.

use cvr_codebook::blocks::cuts;
use cvr_codebook::{Quantiser, Search};
use cvr_core::codec::{EncodeError, Progress};
use cvr_core::volume::{BrickSource, Extent};
use cvr_groups::part_value;
use rayon::prelude::*;

use crate::encode::domain::{Domain, Row};
use crate::encode::train::book::Book;
use crate::stream::geometry::{TOP, VOXELS, block as block_size, number};
use cvr_groups::KeptPlane;

/// Codes and errors of the blocks of one channel of one frame, in the order of the domain's blocks.
#[derive(Clone, Debug, Default)]
pub struct Plane {
    /// Code of each block's mean.
    pub means: Vec<u32>,
    /// Number of codebooks searched: codes of a block.
    pub books: usize,
    /// Codes, block after block.
    pub codes: Vec<u16>,
    /// Squared error of each block after its mean and after each further code: one more than there are codebooks.
    /// Measured on decoder output: integers rounded, in data units, over voxels inside the volume.
    pub errors: Vec<f32>,
}

/// Parameters of the search.
#[derive(Debug)]
pub struct Coder<'a> {
    /// Codebooks, in their order.
    pub books: &'a [Book],
    /// Codes of means count 2^mean_shift.
    pub mean_shift: u32,
    /// Sums become values.
    pub quantiser: Quantiser,
    /// Whether values are integers.
    pub integers: bool,
    /// Squared error, in data units, at which the search of a block stops.
    pub enough: f64,
    /// Voxels of the volume.
    pub extent: Extent,
}

/// A search of every codebook, for one way in which the border cuts a block.
struct Cut<'a> {
    size: [usize; 3],
    inside: Vec<bool>,
    searches: Vec<Search<'a>>,
}

impl<'a> Coder<'a> {
    fn cuts(&self) -> Vec<Cut<'a>> {
        let of_cut = |size: [usize; 3]| {
            let inside = cvr_codebook::blocks::inside(block_size(), 1, size);
            let all = inside.iter().all(|inside| *inside);
            let mask = (!all).then_some(&inside[..]);
            let searches = self.books.iter().map(|book| Search::new(&book.codebook, mask)).collect();
            Cut { size, inside, searches }
        };
        cuts(block_size(), self.extent).into_iter().map(of_cut).collect()
    }

    /// The planes of a domain, frame by frame, channel by channel.
    ///
    /// # Errors
    /// Those of reading, and when `run` was cancelled.
    pub fn code(
        &self,
        source: &dyn BrickSource,
        domain: &Domain,
        run: &Progress<'_>,
    ) -> Result<Vec<Plane>, EncodeError> {
        let cuts = self.cuts();
        let mut planes = Vec::new();
        for frame in domain.frames.clone() {
            let first = planes.len();
            planes.resize_with(first + domain.channels as usize, Plane::default);
            for z in 0..domain.size[2] {
                let of_row = |y| {
                    let rows = domain.row(source, self.quantiser, frame, y, z)?;
                    Ok(rows.iter().map(|row| self.code_row(row, &cuts)).collect())
                };
                let rows = (0..domain.size[1]).into_par_iter().map(of_row);
                let rows: Vec<Vec<Plane>> = rows.collect::<Result<_, EncodeError>>()?;
                for row in rows {
                    for (plane, part) in planes[first..].iter_mut().zip(row) {
                        plane.books = part.books;
                        plane.means.extend(part.means);
                        plane.codes.extend(part.codes);
                        plane.errors.extend(part.errors);
                    }
                }
                let voxels = u64::from(domain.size[0]) * u64::from(domain.size[1]) * VOXELS as u64;
                run.advance(voxels)?;
            }
        }
        Ok(planes)
    }

    fn code_row(&self, row: &Row, cuts: &[Cut<'_>]) -> Plane {
        let (count, books) = (row.values.len() / VOXELS, self.books.len());
        let mut plane = Plane {
            means: Vec::with_capacity(count),
            books,
            codes: vec![0; count * books],
            errors: vec![0.0; count * (books + 1)],
        };
        let mut sums = vec![0_i32; row.values.len()];
        for n in 0..count {
            let Some(cut) = cuts.iter().find(|c| c.size == row.cut(n)) else { continue };
            let vector = &row.values[n * VOXELS..(n + 1) * VOXELS];
            let code = self.mean_code(vector, &cut.inside);
            plane.means.push(code);
            sums[n * VOXELS..(n + 1) * VOXELS].fill((code << self.mean_shift) as i32);
            plane.errors[n * (books + 1)] = self.error(vector, &sums[n * VOXELS..], &cut.inside);
        }
        for (b, book) in self.books.iter().enumerate() {
            for cut in cuts {
                self.search(row, (b, book), cut, &mut sums, &mut plane);
            }
        }
        plane
    }

    /// Searches one codebook for the blocks of one cut that still exceed the error.
    fn search(
        &self,
        row: &Row,
        (b, book): (usize, &Book),
        cut: &Cut<'_>,
        sums: &mut [i32],
        plane: &mut Plane,
    ) {
        let (count, books) = (plane.means.len(), self.books.len());
        let mut wanted = Vec::new();
        let mut residuals = Vec::new();
        for n in (0..count).filter(|n| row.cut(*n) == cut.size) {
            let before = plane.errors[n * (books + 1) + b];
            plane.errors[n * (books + 1) + b + 1] = before;
            if f64::from(before) > self.enough {
                wanted.push(n);
                let places = n * VOXELS..(n + 1) * VOXELS;
                residuals
                    .extend(row.values[places.clone()].iter().zip(&sums[places]).map(|(v, s)| v - *s as f32));
            }
        }
        let nearest = cut.searches[b].rows(&residuals);
        for (n, nearest) in wanted.into_iter().zip(nearest) {
            let places = n * VOXELS..(n + 1) * VOXELS;
            let codeword = book.codebook.codeword(nearest.index as usize);
            sums[places.clone()].iter_mut().zip(codeword).for_each(|(s, c)| *s += *c as i32);
            plane.codes[n * books + b] = nearest.index as u16;
            plane.errors[n * (books + 1) + b + 1] =
                self.error(&row.values[places.clone()], &sums[places], &cut.inside);
        }
    }

    /// The largest error of a sample, integers rounded; blocks keep what `kept` says, or all codes.
    ///
    /// # Errors
    /// Those of reading, and when `run` was cancelled.
    pub fn worst(
        &self,
        source: &dyn BrickSource,
        domain: &Domain,
        planes: &[Plane],
        kept: Option<&[KeptPlane]>,
        run: &Progress<'_>,
    ) -> Result<f64, EncodeError> {
        let (mut worst, [width, height, depth]) = (0.0_f64, domain.size);
        for (f, frame) in domain.frames.clone().enumerate() {
            for z in 0..depth {
                let of_row = |y: u32| {
                    let rows = domain.values(source, frame, y, z, |v| v)?;
                    let mut worst = 0.0_f64;
                    for (c, row) in rows.iter().enumerate() {
                        let p = f * rows.len() + c;
                        for n in 0..width as usize {
                            let block = number([n as u32, y, z], domain.size);
                            worst =
                                worst.max(self.worst_of(row, n, (&planes[p], block), kept.map(|k| &k[p])));
                        }
                    }
                    Ok(worst)
                };
                let rows = (0..height).into_par_iter().map(of_row);
                let rows: Vec<f64> = rows.collect::<Result<_, EncodeError>>()?;
                worst = rows.into_iter().fold(worst, f64::max);
                run.advance(0)?;
            }
        }
        Ok(worst)
    }

    /// The largest error of block `n` of a row of data values, which is that block of its plane.
    fn worst_of(
        &self,
        row: &Row,
        n: usize,
        (plane, block): (&Plane, usize),
        kept: Option<&KeptPlane>,
    ) -> f64 {
        let count = kept.map_or(plane.books, |kept| kept.codes[block].into());
        let mut sums = [(plane.means[block] << self.mean_shift) as i32; VOXELS];
        for (book, code) in self.books.iter().zip(&plane.codes[block * plane.books..]).take(count) {
            let codeword = book.codebook.codeword((*code).into());
            sums.iter_mut().zip(codeword).for_each(|(s, c)| *s += *c as i32);
        }
        if let Some(kept) = kept.filter(|kept| kept.bits[block] > 0) {
            let (words, bits) = (kept.escape(block), kept.bits[block].into());
            sums.iter_mut().enumerate().for_each(|(i, s)| *s += part_value(words, 0, bits, i));
        }
        let inside = cvr_codebook::blocks::inside(block_size(), 1, row.cut(n));
        let mut worst = 0.0_f64;
        for ((v, s), _) in row.values[n * VOXELS..].iter().zip(sums).zip(&inside).filter(|(_, i)| **i) {
            let shown = self.quantiser.value(s.clamp(0, TOP) as u32);
            let shown = if self.integers { shown.round() } else { shown };
            worst = worst.max((f64::from(shown) - f64::from(*v)).abs());
        }
        worst
    }

    /// Code of the mean of the values inside the volume.
    pub fn mean_code(&self, vector: &[f32], inside: &[bool]) -> u32 {
        let (mut sum, mut count) = (0.0, 0.0);
        for (v, _) in vector.iter().zip(inside).filter(|(_, inside)| **inside) {
            sum += f64::from(*v);
            count += 1.0;
        }
        let unit = f64::from(1_u32 << self.mean_shift);
        let top = f64::from(TOP as u32 >> self.mean_shift);
        (sum / count / unit).round().clamp(0.0, top) as u32
    }

    /// Squared error of a decoded block.
    pub fn error(&self, vector: &[f32], sums: &[i32], inside: &[bool]) -> f32 {
        let (step, offset) = (f64::from(self.quantiser.step()), f64::from(self.quantiser.offset()));
        let mut error = 0.0;
        for ((v, s), _) in vector.iter().zip(sums).zip(inside).filter(|(_, inside)| **inside) {
            let shown = (*s).clamp(0, TOP);
            let difference = if self.integers {
                let value = offset + step * f64::from(*v);
                f64::from(self.quantiser.value(shown as u32)).round() - value.round()
            } else {
                step * (f64::from(shown) - f64::from(*v))
            };
            error += difference * difference;
        }
        error as f32
    }
}
