//! Blocks coded directly behind their codes: which ways there are, and the words of those that are chosen.

use cvr_codebook::blocks::{cuts, inside};
use cvr_core::codec::EncodeError;
use cvr_groups::{Candidate, Escape, KeptPlane, Prices, Rest, Scale, Ways};
use rayon::prelude::*;

use crate::encode::closed_loop::{Coder, Plane};
use crate::encode::domain::{Domain, Row};
use crate::encode::train::book::Book;
use crate::encode::tuned::escapes::COVERED;
use crate::encode::work::{Coded, Sets, Work};
use crate::stream::geometry::{VOXELS, block as block_size};

/// By table and plane.
pub type AllWays = Vec<Vec<Ways>>;

/// Everything that an escape of a block depends on.
struct Coding<'a> {
    coder: Coder<'a>,
    cuts: Vec<([usize; 3], Vec<bool>)>,
    /// The largest step that loses nothing of integers: behind a mean alone, and behind codes.
    exact: Option<[Scale; 2]>,
    /// Squared error that a bit is worth at least, in data units.
    price: f64,
    /// Bits of a code.
    width: f64,
}

/// One block: its values in units of sums, and the voxels inside the volume.
#[derive(Copy, Clone)]
struct Block<'a> {
    values: &'a [f32],
    inside: &'a [bool],
    plane: &'a Plane,
    number: usize,
}

impl<'a> Coding<'a> {
    fn of(work: &Work<'_>, coded: &'a Coded, price: f64) -> Self {
        let width = coded.books.iter().map(Book::width).max().unwrap_or(0);
        let unit = 1.0 / work.unit();
        let with_inside = |size| (size, inside(block_size(), 1, size));
        Self {
            coder: work.coder(&coded.books, coded.mean_shift, 0.0),
            cuts: cuts(block_size(), work.layout.extent).into_iter().map(with_inside).collect(),
            exact: (work.layout.sample.is_integer() && unit >= 1.0)
                .then(|| [1.0, COVERED].map(|part| Scale::at_most(part * unit))),
            price,
            width: f64::from(width),
        }
    }

    fn block<'b>(&'b self, row: &'b Row, n: usize, plane: &'b Plane, number: usize) -> Option<Block<'b>> {
        let (_, inside) = self.cuts.iter().find(|cut| cut.0 == row.cut(n))?;
        Some(Block { values: &row.values[n * VOXELS..(n + 1) * VOXELS], inside, plane, number })
    }

    /// The sums of a block that keeps so many codes.
    fn sums(&self, block: &Block<'_>, count: usize) -> [i32; VOXELS] {
        let plane = block.plane;
        let mut sums = [(plane.means[block.number] << self.coder.mean_shift) as i32; VOXELS];
        for (book, code) in
            self.coder.books.iter().zip(&plane.codes[block.number * plane.books..]).take(count)
        {
            let codeword = book.codebook.codeword((*code).into());
            sums.iter_mut().zip(codeword).for_each(|(s, c)| *s += *c as i32);
        }
        sums
    }

    /// The best escape in so many bits of what some sums leave, and the squared error then.
    fn escape(&self, block: &Block<'_>, sums: &[i32; VOXELS], count: usize, bits: u32) -> (Escape, f32) {
        let mut values = [0.0_f32; VOXELS];
        values.iter_mut().zip(block.values).zip(sums).for_each(|((r, v), s)| *r = v - *s as f32);
        let rest = Rest::of(&values, block.inside);
        let error = |escape: &Escape| {
            let shown = std::array::from_fn::<i32, VOXELS, _>(|i| sums[i] + escape.value(i));
            self.coder.error(block.values, &shown, block.inside)
        };
        rest.nearest(bits, self.exact.map(|exact| exact[usize::from(count > 0)]), error)
    }

    /// Ways that may pay at some price of the least or more.
    fn ways(&self, block: &Block<'_>, found: impl FnMut(Candidate)) {
        let stride = block.plane.books + 1;
        let errors = &block.plane.errors[block.number * stride..][..stride];
        let behind = |count: usize| {
            let sums = self.sums(block, count);
            move |bits| self.escape(block, &sums, count, bits).1
        };
        Prices { bit: self.price, width: self.width, parts: 1 }.ways(errors, behind, found);
    }
}

/// Runs `of_row` for each row of blocks of a domain, in parallel, and hands what it yields to `take` in order: plane by plane
/// within a layer of blocks.
fn by_row<T: Send>(
    work: &Work<'_>,
    domain: &Domain,
    of_row: impl Fn(&Row, usize, usize) -> T + Sync,
    mut take: impl FnMut(usize, T),
) -> Result<(), EncodeError> {
    let [width, height, depth] = domain.size;
    for (f, frame) in domain.frames.clone().enumerate() {
        for z in 0..depth {
            let rows = (0..height).into_par_iter().map(|y| {
                let rows = domain.row(work.source, work.quantiser, frame, y, z)?;
                let first = (z as usize * height as usize + y as usize) * width as usize;
                let of_channel = |(c, row)| of_row(row, f * domain.channels as usize + c, first);
                Ok(rows.iter().enumerate().map(of_channel).collect())
            });
            let rows: Vec<Vec<T>> = rows.collect::<Result<_, EncodeError>>()?;
            for row in rows {
                for (c, found) in row.into_iter().enumerate() {
                    take(f * domain.channels as usize + c, found);
                }
            }
            work.run.advance(0)?;
        }
    }
    Ok(())
}

/// Ways to escape every block for which one may pay at `price`, in data units, or above it.
///
/// # Errors
/// Those of reading, and when the run was cancelled.
pub fn ways(work: &Work<'_>, sets: &Sets, price: f64) -> Result<AllWays, EncodeError> {
    let of_table = |(coded, domain): (&Coded, &Domain)| {
        let coding = Coding::of(work, coded, price);
        let mut all = vec![Ways::default(); coded.planes.len()];
        let of_row = |row: &Row, p: usize, first: usize| {
            let mut ways = Ways::default();
            for n in 0..row.values.len() / VOXELS {
                let mut candidates = Vec::new();
                if let Some(block) = coding.block(row, n, &coded.planes[p], first + n) {
                    coding.ways(&block, |candidate| candidates.push(candidate));
                }
                ways.push(candidates);
            }
            ways
        };
        by_row(work, domain, of_row, |p, ways| all[p].append(&ways))?;
        Ok(all)
    };
    sets.iter().flatten().zip(work.domains()).map(of_table).collect()
}

/// The words of the escapes that were chosen: `bits` of each block of each plane.
///
/// # Errors
/// Those of reading, and when the run was cancelled.
pub fn write(
    work: &Work<'_>,
    (coded, domain): (&Coded, &Domain),
    planes: &mut [KeptPlane],
) -> Result<(), EncodeError> {
    let coding = Coding::of(work, coded, 1.0);
    let chosen: &[KeptPlane] = planes;
    let of_row = |row: &Row, p: usize, first: usize| {
        let (mut words, mut ends) = (Vec::new(), Vec::new());
        for n in 0..row.values.len() / VOXELS {
            let (count, bits) = (chosen[p].codes[first + n].into(), chosen[p].bits[first + n].into());
            if let Some(block) = coding.block(row, n, &coded.planes[p], first + n).filter(|_| bits > 0) {
                let sums = coding.sums(&block, count);
                coding.escape(&block, &sums, count, bits).0.write(&mut words);
            }
            ends.push(words.len());
        }
        (words, ends)
    };
    let mut found: Vec<(Vec<u32>, Vec<usize>)> = vec![Default::default(); planes.len()];
    by_row(work, domain, of_row, |p, (words, ends)| {
        let begun = found[p].0.len();
        found[p].0.extend(words);
        found[p].1.extend(ends.into_iter().map(|end| begun + end));
    })?;
    for (plane, (words, ends)) in planes.iter_mut().zip(found) {
        (plane.words, plane.ends) = (words, ends);
    }
    Ok(())
}
