//! The separable wavelet transform of a whole volume (paper, section 2.1).

mod axes;
mod filter;
pub mod gain;
mod lines;

use rayon::prelude::*;

pub use axes::Shape;
pub use filter::{Extension, Filter, Half, Kernel, Step};
pub use lines::{Prepared, Sample, Wide};

use crate::stream::pyramid::{Band, Pyramid};

/// A box of values: x fastest.
struct Grid<T> {
    values: Vec<T>,
    extent: [usize; 3],
}

impl<T: Sample> Grid<T> {
    /// Start of row `i` of a box at `origin` with `rows` rows per slice.
    fn row(&self, origin: [usize; 3], i: usize, rows: usize) -> usize {
        let (y, z) = (origin[1] + i % rows, origin[2] + i / rows);
        (z * self.extent[1] + y) * self.extent[0] + origin[0]
    }

    /// The same values in a box of another extent, cut or with zeros behind them, through a function.
    fn mapped<U: Sample>(&self, extent: [usize; 3], value: impl Fn(T) -> U) -> Grid<U> {
        let mut out = Grid { values: vec![U::default(); extent.iter().product()], extent };
        let [x, y, z] = [0, 1, 2].map(|axis| extent[axis].min(self.extent[axis]));
        for i in 0..y * z {
            let (from, to) = (self.row([0; 3], i, y), out.row([0; 3], i, y));
            let pairs = out.values[to..to + x].iter_mut().zip(&self.values[from..from + x]);
            pairs.for_each(|(to, from)| *to = value(*from));
        }
        out
    }

    /// The same values in a box of another extent, cut or with zeros behind them.
    fn resized(self, extent: [usize; 3]) -> Self {
        if extent == self.extent { self } else { self.mapped(extent, |v| v) }
    }
}

/// First coefficient of a band in a box whose low bands end at `low`.
fn origin(band: &Band, low: [usize; 3]) -> [usize; 3] {
    [0, 1, 2].map(|axis| if band.high[axis] { low[axis] } else { 0 })
}

/// The coefficients of a volume of [`Pyramid::extent`]`(0)` samples, in the order of the bands.
///
/// Only the finest level is kept in the type of the samples: there it saves memory, and its values are rounded three
/// times. All other coefficients are rounded once.
///
/// # Panics
/// When `volume` has another number of samples.
#[must_use]
pub fn forward<T: Sample>(filter: Filter, pyramid: &Pyramid, volume: Vec<T>) -> Vec<T> {
    let (prepared, levels) = (Prepared::new(filter), pyramid.levels());
    assert_eq!(volume.len(), pyramid.extent(0).iter().product::<usize>(), "samples of a volume");
    let volume = Grid { values: volume, extent: pyramid.extent(0) };
    if levels == 0 {
        return volume.values;
    }
    let mut out = vec![T::default(); pyramid.coefficients(levels)];
    let finest = decomposed(&prepared, pyramid, 0, filter.pads(), volume, &mut out);
    let mut low = finest.mapped(pyramid.extent(1), T::widen);
    drop(finest);
    for done in 1..levels {
        let level = decomposed(&prepared, pyramid, done, filter.pads(), low, &mut out);
        low = level.resized(pyramid.extent(done + 1));
    }
    let first = pyramid.bands()[0].range();
    out[first].iter_mut().zip(&low.values).for_each(|(to, from)| *to = T::round(*from));
    out
}

/// One decomposition after `done` others: the transformed box, whose high bands are written to `out`.
fn decomposed<S: Sample<Wide = T::Wide>, T: Sample>(
    filter: &Prepared,
    pyramid: &Pyramid,
    done: usize,
    pads: bool,
    samples: Grid<S>,
    out: &mut [T],
) -> Grid<S> {
    let shape = Shape::new(samples.extent, pads);
    let mut level = samples.resized(shape.coefficients);
    axes::forward(filter, &mut level.values, &shape);
    let low = pyramid.extent(done + 1);
    for band in pyramid.level(pyramid.levels() - 1 - done).iter().filter(|band| !band.is_empty()) {
        let [x, y, _] = band.extent;
        let rows = out[band.range()].par_chunks_exact_mut(x).enumerate();
        rows.for_each(|(i, row)| {
            let from = &level.values[level.row(origin(band, low), i, y)..];
            row.iter_mut().zip(from).for_each(|(to, from)| *to = T::round(from.widen()));
        });
    }
    level
}

/// The volume of LLL and the `levels` coarsest levels. All levels give the samples; fewer give the low band of the
/// next finer level, whose values are [`gain::low`] times as large as the samples. `value` is a coefficient of a band.
///
/// # Panics
/// When `coefficients` are not as many as these levels have.
#[must_use]
pub fn inverse<T: Sample, C: Copy + Sync>(
    filter: Filter,
    pyramid: &Pyramid,
    levels: usize,
    coefficients: &[C],
    value: impl Fn(&Band, C) -> T::Wide + Sync,
) -> Vec<T> {
    let prepared = Prepared::new(filter);
    assert_eq!(coefficients.len(), pyramid.coefficients(levels), "coefficients of {levels} levels");
    let first = &pyramid.bands()[0];
    let values = coefficients[first.range()].iter().map(|c| value(first, *c)).collect();
    let mut low = Grid { values, extent: first.extent };
    if levels == 0 {
        return low.values.into_iter().map(T::round).collect();
    }
    for level in 0..levels - 1 {
        let shape = Shape::new(pyramid.extent(pyramid.levels() - 1 - level), filter.pads());
        let grid = low.mapped(shape.coefficients, |v| v);
        low = composed(&prepared, pyramid.level(level), low.extent, &shape, grid, (coefficients, &value));
    }
    let shape = Shape::new(pyramid.extent(pyramid.levels() - levels), filter.pads());
    let grid = low.mapped(shape.coefficients, T::round);
    composed(&prepared, pyramid.level(levels - 1), low.extent, &shape, grid, (coefficients, &value)).values
}

/// The inverse of [`decomposed`]. `grid` holds the low band.
fn composed<S: Sample, C: Copy + Sync>(
    filter: &Prepared,
    bands: &[Band],
    low: [usize; 3],
    shape: &Shape,
    mut grid: Grid<S>,
    (coefficients, value): (&[C], &(impl Fn(&Band, C) -> S::Wide + Sync)),
) -> Grid<S> {
    let [x, y, _] = grid.extent;
    // Slice by slice, so that threads may write side by side.
    grid.values.par_chunks_exact_mut(x * y).enumerate().for_each(|(z, slice)| {
        for band in bands.iter().filter(|band| !band.is_empty()) {
            let [first_x, first_y, first_z] = origin(band, low);
            let [width, height, depth] = band.extent;
            if !(first_z..first_z + depth).contains(&z) {
                continue;
            }
            let from = &coefficients[band.start + (z - first_z) * width * height..][..width * height];
            for (row, from) in slice[first_y * x..].chunks_exact_mut(x).zip(from.chunks_exact(width)) {
                let to = row[first_x..].iter_mut().zip(from);
                to.for_each(|(to, from)| *to = S::round(value(band, *from)));
            }
        }
    });
    axes::inverse(filter, &mut grid.values, shape);
    grid.resized(shape.samples)
}

#[cfg(test)]
mod tests;
