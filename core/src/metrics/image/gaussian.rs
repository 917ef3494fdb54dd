//! Convolution of planes with separable kernels.

use rayon::prelude::*;

/// A plane of numbers in rows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) size: [usize; 2],
    pub(super) values: Vec<f64>,
}

impl Plane {
    /// The plane with a function applied to each value.
    pub(super) fn map(&self, value: impl Fn(f64) -> f64) -> Self {
        Self { size: self.size, values: self.values.iter().map(|v| value(*v)).collect() }
    }

    /// The products of two planes of one size.
    pub(super) fn times(&self, other: &Self) -> Self {
        let values = self.values.iter().zip(&other.values).map(|(a, b)| a * b).collect();
        Self { size: self.size, values }
    }

    /// Correlates rows with one kernel of odd length and columns with another, wherever both lie inside the plane. The
    /// result is smaller by the length of a kernel minus one.
    ///
    /// # Panics
    /// When a kernel is longer than the plane.
    pub(super) fn inner(&self, along_x: &[f64], along_y: &[f64]) -> Self {
        let [width, height] = self.size;
        let size = [width + 1 - along_x.len(), height + 1 - along_y.len()];
        let mut rows = vec![0.0; size[0] * height];
        rows.par_chunks_mut(size[0]).zip(self.values.par_chunks(width)).for_each(|(to, from)| {
            for (weight, shift) in along_x.iter().zip(0..) {
                to.iter_mut().zip(&from[shift..]).for_each(|(to, from)| *to += weight * from);
            }
        });
        let mut values = vec![0.0; size[0] * size[1]];
        values.par_chunks_mut(size[0]).enumerate().for_each(|(y, to)| {
            for (weight, from) in along_y.iter().zip(rows[y * size[0]..].chunks_exact(size[0])) {
                to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
            }
        });
        Self { size, values }
    }

    /// The same over the whole plane, whose border is repeated beyond it. Kernels are of one length.
    pub(super) fn whole(&self, along_x: &[f64], along_y: &[f64]) -> Self {
        let repeated = |at: isize, n: usize| at.clamp(0, n as isize - 1) as usize;
        self.widened(along_x.len() / 2, repeated).inner(along_x, along_y)
    }

    /// The plane with this many more pixels on each side, mirrored at its border. Border pixels appear twice. In a narrow
    /// plane the mirrors repeat.
    pub(super) fn mirrored(&self, by: usize) -> Self {
        let mirrored = |at: isize, n: usize| {
            let at = at.rem_euclid(2 * n as isize) as usize;
            at.min(2 * n - 1 - at)
        };
        self.widened(by, mirrored)
    }

    /// The plane, extended on each side by a number of pixels. `place` maps a coordinate to its position in the plane.
    fn widened(&self, by: usize, place: impl Fn(isize, usize) -> usize) -> Self {
        let [width, height] = self.size;
        let size = [width + 2 * by, height + 2 * by];
        let inside = |at: usize, n: usize| place(at as isize - by as isize, n);
        let places = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        let values = places.map(|(x, y)| self.values[inside(y, height) * width + inside(x, width)]).collect();
        Self { size, values }
    }
}

/// `exp(−x² / 2σ²)` at −radius, …, radius, with the sum 1.
pub(super) fn gaussian(sigma: f64, radius: usize) -> Vec<f64> {
    let at = |i: usize| i as f64 - radius as f64;
    let weights: Vec<f64> =
        (0..=2 * radius).map(|i| (-at(i) * at(i) / (2.0 * sigma * sigma)).exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|w| w / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirrors_show_the_border_twice_and_face_each_other() {
        let row = |values: &[f64]| Plane { size: [values.len(), 1], values: values.to_vec() }.mirrored(4);
        let wide = row(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(wide.size, [13, 9]);
        let expected = [4.0, 3.0, 2.0, 1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 4.0, 3.0, 2.0];
        assert!(wide.values.chunks_exact(13).all(|row| row == expected), "{wide:?}");
        assert_eq!(row(&[1.0, 2.0]).values[..10], [1.0, 2.0, 2.0, 1.0, 1.0, 2.0, 2.0, 1.0, 1.0, 2.0]);
    }
}
