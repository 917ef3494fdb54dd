//! One decomposition of a box: all lines along x and y of each slice, then all lines along z, in bundles.

use rayon::prelude::*;

use super::lines::{Bundle, LANES, Prepared, Sample, Wide};

/// The shape of one decomposition.
#[derive(Copy, Clone, Debug)]
pub struct Shape {
    /// Samples along x, y and z.
    pub samples: [usize; 3],
    /// Coefficients along x, y and z, low ones first. At least as many as samples.
    pub coefficients: [usize; 3],
}

impl Shape {
    /// Of a box of `samples`. `pads`: see [`super::Filter::pads`].
    #[must_use]
    pub fn new(samples: [usize; 3], pads: bool) -> Self {
        let coefficients = samples.map(|n| if pads && n > 1 { n.next_multiple_of(2) } else { n });
        Self { samples, coefficients }
    }

    /// Number of coefficients.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.coefficients[0] * self.coefficients[1] * self.coefficients[2]
    }
}

fn widen<T: Sample>(row: &mut [T::Wide; LANES], from: &[T]) {
    row.iter_mut().zip(from).for_each(|(wide, sample)| *wide = sample.widen());
}

fn round<T: Sample>(to: &mut [T], row: &[T::Wide; LANES]) {
    to.iter_mut().zip(row).for_each(|(sample, wide)| *sample = T::round(*wide));
}

/// Where the rows of a bundle lie in memory.
trait Lines<T: Sample> {
    /// Reads sample `i` of all lanes.
    fn get(&self, i: usize, row: &mut [T::Wide; LANES]);
    /// Writes it.
    fn set(&mut self, i: usize, row: &[T::Wide; LANES]);
}

/// Up to [`LANES`] lines that follow each other in memory, each of `stride` samples.
struct Along<'a, T> {
    lines: &'a mut [T],
    stride: usize,
}

impl<T: Sample> Lines<T> for Along<'_, T> {
    fn get(&self, i: usize, row: &mut [T::Wide; LANES]) {
        for (v, line) in row.iter_mut().zip(self.lines.chunks_exact(self.stride)) {
            *v = line[i].widen();
        }
    }

    fn set(&mut self, i: usize, row: &[T::Wide; LANES]) {
        for (v, line) in row.iter().zip(self.lines.chunks_exact_mut(self.stride)) {
            line[i] = T::round(*v);
        }
    }
}

/// Up to [`LANES`] neighbouring columns from `first` on, of rows that lie `stride` apart.
struct Across<'a, T> {
    rows: &'a mut [T],
    stride: usize,
    first: usize,
    count: usize,
}

impl<T: Sample> Lines<T> for Across<'_, T> {
    fn get(&self, i: usize, row: &mut [T::Wide; LANES]) {
        let start = i * self.stride + self.first;
        widen(row, &self.rows[start..start + self.count]);
    }

    fn set(&mut self, i: usize, row: &[T::Wide; LANES]) {
        let start = i * self.stride + self.first;
        round(&mut self.rows[start..start + self.count], row);
    }
}

/// The same of rows that lie anywhere.
struct Rows<'a, 'b, T> {
    rows: &'a mut [&'b mut [T]],
    first: usize,
    count: usize,
}

impl<T: Sample> Lines<T> for Rows<'_, '_, T> {
    fn get(&self, i: usize, row: &mut [T::Wide; LANES]) {
        widen(row, &self.rows[i][self.first..self.first + self.count]);
    }

    fn set(&mut self, i: usize, row: &[T::Wide; LANES]) {
        round(&mut self.rows[i][self.first..self.first + self.count], row);
    }
}

/// Samples to coefficients, or back.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
enum Direction {
    Forward,
    Inverse,
}

/// Transforms a bundle of lines of `samples`, more than one, in place.
fn transform<T: Sample>(
    filter: &Prepared,
    direction: Direction,
    lines: &mut impl Lines<T>,
    (samples, coefficients): (usize, usize),
    bundle: &mut Bundle<T::Wide>,
) {
    let low = samples.div_ceil(2);
    bundle.even.resize(low, [Default::default(); LANES]);
    bundle.odd.resize(coefficients - low, [Default::default(); LANES]);
    let Bundle { even, odd, .. } = bundle;
    if direction == Direction::Forward {
        even.iter_mut().enumerate().for_each(|(i, row)| lines.get(2 * i, row));
        // A padded line repeats its last sample.
        odd.iter_mut().enumerate().for_each(|(i, row)| lines.get((2 * i + 1).min(samples - 1), row));
        T::Wide::forward(filter, bundle);
        bundle.even.iter().chain(&bundle.odd).enumerate().for_each(|(i, row)| lines.set(i, row));
    } else {
        even.iter_mut().chain(odd).enumerate().for_each(|(i, row)| lines.get(i, row));
        T::Wide::inverse(filter, bundle);
        let odd = bundle.odd.iter().take(samples / 2);
        bundle.even.iter().enumerate().for_each(|(i, row)| lines.set(2 * i, row));
        odd.enumerate().for_each(|(i, row)| lines.set(2 * i + 1, row));
    }
}

/// All lines along x and y of a slice.
fn slice<T: Sample>(
    filter: &Prepared,
    direction: Direction,
    slice: &mut [T],
    shape: &Shape,
    bundle: &mut Bundle<T::Wide>,
) {
    let ([nx, ny, _], [x, y, _]) = (shape.samples, shape.coefficients);
    let along_x = |slice: &mut [T], bundle: &mut Bundle<T::Wide>| {
        if nx > 1 {
            for lines in slice[..x * ny].chunks_mut(x * LANES) {
                transform(filter, direction, &mut Along { lines, stride: x }, (nx, x), bundle);
            }
        }
    };
    if direction == Direction::Forward {
        along_x(slice, bundle);
    }
    if ny > 1 {
        for first in (0..x).step_by(LANES) {
            let mut lines = Across { rows: slice, stride: x, first, count: LANES.min(x - first) };
            transform(filter, direction, &mut lines, (ny, y), bundle);
        }
    }
    if direction == Direction::Inverse {
        along_x(slice, bundle);
    }
}

/// All lines along z.
fn depth<T: Sample>(filter: &Prepared, direction: Direction, data: &mut [T], shape: &Shape) {
    let [x, y, z] = shape.coefficients;
    if shape.samples[2] < 2 {
        return;
    }
    // One list of rows for each y, so that threads may change them side by side.
    let mut rows: Vec<Vec<&mut [T]>> = (0..y).map(|_| Vec::with_capacity(z)).collect();
    data.chunks_exact_mut(x).enumerate().for_each(|(i, row)| rows[i % y].push(row));
    rows.into_par_iter().for_each_init(Bundle::default, |bundle, mut rows| {
        for first in (0..x).step_by(LANES) {
            let mut lines = Rows { rows: &mut rows, first, count: LANES.min(x - first) };
            transform(filter, direction, &mut lines, (shape.samples[2], z), bundle);
        }
    });
}

/// Transforms a box in place. `data` has the coefficients' shape; beyond the samples it may hold anything.
pub fn forward<T: Sample>(filter: &Prepared, data: &mut [T], shape: &Shape) {
    let area = shape.coefficients[0] * shape.coefficients[1];
    let slices = data[..area * shape.samples[2]].par_chunks_mut(area);
    slices.for_each_init(Bundle::default, |bundle, data| {
        slice(filter, Direction::Forward, data, shape, bundle);
    });
    depth(filter, Direction::Forward, data, shape);
}

/// The inverse of [`forward`].
pub fn inverse<T: Sample>(filter: &Prepared, data: &mut [T], shape: &Shape) {
    depth(filter, Direction::Inverse, data, shape);
    let area = shape.coefficients[0] * shape.coefficients[1];
    let slices = data[..area * shape.samples[2]].par_chunks_mut(area);
    slices.for_each_init(Bundle::default, |bundle, data| {
        slice(filter, Direction::Inverse, data, shape, bundle);
    });
}
