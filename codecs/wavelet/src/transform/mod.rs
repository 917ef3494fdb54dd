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

impl<T: Copy + Default> Grid<T> {
    fn new(extent: [usize; 3]) -> Self {
        Self { values: vec![T::default(); extent.iter().product()], extent }
    }

    /// The same values in a box of another extent: cut, or with zeros behind them.
    fn resized(self, extent: [usize; 3]) -> Self {
        if extent == self.extent {
            return self;
        }
        let mut out = Self::new(extent);
        let [x, y, z] = [0, 1, 2].map(|axis| extent[axis].min(self.extent[axis]));
        for i in 0..y * z {
            let (from, to) = (self.row([0; 3], i, y), out.row([0; 3], i, y));
            out.values[to..to + x].copy_from_slice(&self.values[from..from + x]);
        }
        out
    }

    /// Start of row `i` of a box at `origin` with `rows` rows per slice.
    fn row(&self, origin: [usize; 3], i: usize, rows: usize) -> usize {
        let (y, z) = (origin[1] + i % rows, origin[2] + i / rows);
        (z * self.extent[1] + y) * self.extent[0] + origin[0]
    }
}

/// First coefficient of a band in a box whose low bands end at `low`.
fn origin(band: &Band, low: [usize; 3]) -> [usize; 3] {
    [0, 1, 2].map(|axis| if band.high[axis] { low[axis] } else { 0 })
}

/// The coefficients of a volume of [`Pyramid::extent`]`(0)` samples, in the order of the bands.
///
/// # Panics
/// When `volume` has another number of samples.
#[must_use]
pub fn forward<T: Sample>(filter: Filter, pyramid: &Pyramid, volume: Vec<T>) -> Vec<T> {
    let prepared = Prepared::new(filter);
    assert_eq!(volume.len(), pyramid.extent(0).iter().product::<usize>(), "samples of a volume");
    let mut current =
        Grid { values: volume.par_iter().map(|v| v.widen()).collect(), extent: pyramid.extent(0) };
    drop(volume);
    let mut out = vec![T::default(); pyramid.coefficients(pyramid.levels())];
    for done in 0..pyramid.levels() {
        let shape = Shape::new(current.extent, filter.pads());
        let mut level = current.resized(shape.coefficients);
        axes::forward(&prepared, &mut level.values, &shape);
        let low = pyramid.extent(done + 1);
        for band in pyramid.level(pyramid.levels() - 1 - done).iter().filter(|band| !band.is_empty()) {
            let [x, y, _] = band.extent;
            let rows = out[band.range()].par_chunks_exact_mut(x).enumerate();
            rows.for_each(|(i, row)| {
                let from = &level.values[level.row(origin(band, low), i, y)..];
                row.iter_mut().zip(from).for_each(|(to, from)| *to = T::round(*from));
            });
        }
        current = level.resized(low);
    }
    let low = pyramid.bands()[0].range();
    out[low].iter_mut().zip(&current.values).for_each(|(to, from)| *to = T::round(*from));
    out
}

/// The volume of LLL and the `levels` coarsest levels. All levels give the samples; fewer give the low band of the
/// next finer level, whose values are [`gain::low`] times as large as the samples. `value` is a coefficient of a band.
///
/// # Panics
/// When `coefficients` are not as many as these levels have.
#[must_use]
pub fn inverse<T: Wide, C: Copy + Sync>(
    filter: Filter,
    pyramid: &Pyramid,
    levels: usize,
    coefficients: &[C],
    value: impl Fn(&Band, C) -> T + Sync,
) -> Vec<T> {
    let prepared = Prepared::new(filter);
    assert_eq!(coefficients.len(), pyramid.coefficients(levels), "coefficients of {levels} levels");
    let first = &pyramid.bands()[0];
    let values = coefficients[first.range()].iter().map(|c| value(first, *c)).collect();
    let mut current = Grid { values, extent: first.extent };
    for level in 0..levels {
        let samples = pyramid.extent(pyramid.levels() - 1 - level);
        let shape = Shape::new(samples, filter.pads());
        let low = current.extent;
        let mut grid = current.resized(shape.coefficients);
        let [x, y, _] = grid.extent;
        let bands = pyramid.level(level);
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
                    to.for_each(|(to, from)| *to = value(band, *from));
                }
            }
        });
        axes::inverse(&prepared, &mut grid.values, &shape);
        current = grid.resized(samples);
    }
    current.values
}

#[cfg(test)]
mod tests;
