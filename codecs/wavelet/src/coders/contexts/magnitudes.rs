//! Magnitudes of coefficients around a coefficient, whose sum tells how large it may be.

use std::ops::Range;

/// Largest magnitude that counts. All weighted sums stay below 2¹⁶.
const LARGEST: u32 = 1920;

/// Weight of the three coefficients before one along x, y and z. Those that touch it along an edge, its parent, and the
/// coefficients at its place in the bands before it have weight 1.
pub const NEAR: u16 = 4;

/// The magnitude as it counts.
#[inline]
#[must_use]
pub fn counted(coefficient: i32) -> u16 {
    coefficient.unsigned_abs().min(LARGEST) as u16
}

/// Magnitudes of the coefficients of a band or of a part of it, with a border of zeros.
#[derive(Clone, Debug)]
pub struct Magnitudes {
    values: Vec<u16>,
    /// Whether a row with its border may hold something else than zeros. Sums leave out rows that do not.
    busy: Vec<bool>,
    extent: [usize; 3],
}

/// The parents of a part of a band: the magnitudes of the whole band one level coarser, and the first slice of the part.
#[derive(Copy, Clone, Debug)]
pub struct Parents<'a> {
    /// Not empty.
    pub magnitudes: &'a Magnitudes,
    /// Slices of the band before the part.
    pub first_slice: usize,
}

impl Magnitudes {
    /// All 0.
    #[must_use]
    pub fn new(extent: [usize; 3]) -> Self {
        let [x, y, z] = extent;
        let rows = (y + 2) * (z + 2);
        Self { values: vec![0; (x + 2) * rows], busy: vec![false; rows], extent }
    }

    /// Of the coefficients of a band.
    #[must_use]
    pub fn of(coefficients: &[i32], extent: [usize; 3]) -> Self {
        let mut out = Self::new(extent);
        let [x, y, _] = extent;
        for (i, row) in coefficients.chunks_exact(x.max(1)).enumerate() {
            let to = out.row_mut(i % y, i / y).iter_mut().zip(row);
            to.for_each(|(to, coefficient)| *to = counted(*coefficient));
            out.set_busy(i % y, i / y, row.iter().any(|coefficient| *coefficient != 0));
        }
        out
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.extent.contains(&0)
    }

    fn number(&self, y: usize, z: usize) -> usize {
        z * (self.extent[1] + 2) + y
    }

    fn place(&self, y: usize, z: usize) -> Range<usize> {
        let (row, i) = (self.extent[0] + 2, self.number(y, z));
        i * row..(i + 1) * row
    }

    /// Says whether a row holds something else than zeros.
    pub fn set_busy(&mut self, y: usize, z: usize, busy: bool) {
        let i = self.number(y + 1, z + 1);
        self.busy[i] = busy;
    }

    fn is_busy(&self, rows: &[(usize, usize)]) -> bool {
        rows.iter().any(|(y, z)| self.busy[self.number(*y, *z)])
    }

    /// A row with its border, whose first row and slice have number 0: row `y + 1` of slice `z + 1` holds the
    /// coefficients of row `y` in slice `z`.
    fn bordered(&self, y: usize, z: usize) -> &[u16] {
        &self.values[self.place(y, z)]
    }

    /// A row without its border.
    pub fn row_mut(&mut self, y: usize, z: usize) -> &mut [u16] {
        let Range { start, end } = self.place(y + 1, z + 1);
        &mut self.values[start + 1..end - 1]
    }

    /// The activity of a row of this part: what its surroundings amount to, except for the coefficient before each
    /// one along x, which is not known yet. `done` are the same parts of the bands before it at the same level.
    pub fn activity(
        &self,
        row: (usize, usize),
        parents: Option<Parents<'_>>,
        done: &[Self],
        out: &mut [u16],
    ) {
        let (n, (y, z)) = (out.len(), row);
        out.fill(0);
        let rows = [(y, z + 1), (y + 1, z), (y, z), (y + 2, z)];
        if self.is_busy(&rows) {
            let [north, up, up_north, up_south] = rows.map(|(y, z)| &self.bordered(y, z)[..n + 2]);
            for i in 0..n {
                let edges = north[i] + north[i + 2] + up[i] + up[i + 2] + up_north[i + 1] + up_south[i + 1];
                out[i] = NEAR * (north[i + 1] + up[i + 1]) + edges;
            }
        }
        if let Some(Parents { magnitudes, first_slice }) = parents {
            // A band may have one coefficient more than twice its parent.
            let [x, py, pz] = magnitudes.extent;
            let place = ((y / 2).min(py - 1) + 1, ((z + first_slice) / 2).min(pz - 1) + 1);
            if magnitudes.is_busy(&[place]) {
                let row = magnitudes.bordered(place.0, place.1);
                for (pair, parent) in
                    out.chunks_mut(2).zip(row[1..=x].iter().chain(std::iter::repeat(&row[x])))
                {
                    pair.iter_mut().for_each(|v| *v += parent);
                }
            }
        }
        for other in done {
            other.add_places(row, out);
        }
    }

    /// Adds what lies at the same place in another band, and a fourth of what lies around it.
    fn add_places(&self, (y, z): (usize, usize), out: &mut [u16]) {
        let [x, height, depth] = self.extent;
        if y >= height || z >= depth {
            return;
        }
        let n = x.min(out.len());
        let rows = [(y + 1, z + 1), (y, z + 1), (y + 2, z + 1), (y + 1, z), (y + 1, z + 2)];
        if !self.is_busy(&rows) {
            return;
        }
        let [row, north, south, up, down] = rows.map(|(y, z)| &self.bordered(y, z)[..n + 2]);
        for i in 0..n {
            let around = row[i] + row[i + 2] + north[i + 1] + south[i + 1] + up[i + 1] + down[i + 1];
            out[i] += row[i + 1] + around / 4;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_sum_overflows() {
        let extent = [6, 4, 4];
        let full = Magnitudes::of(&[i32::MAX; 96], extent);
        let done = vec![full.clone(); 6];
        let parents = Parents { magnitudes: &full, first_slice: 3 };
        let mut out = [0; 6];
        full.activity((1, 1), Some(parents), &done, &mut out);
        let expected = LARGEST * (2 * 4 + 6 + 1 + 6) + 6 * (6 * LARGEST / 4);
        assert_eq!(u32::from(out[2]), expected);
        assert!(expected + LARGEST * u32::from(NEAR) <= u32::from(u16::MAX));
    }

    #[test]
    fn a_parent_of_a_longer_band_is_the_last_one() {
        let parent = Magnitudes::of(&[1, 2, 3, 4], [2, 2, 1]);
        let own = Magnitudes::new([5, 5, 2]);
        let mut out = [0; 5];
        own.activity((4, 1), Some(Parents { magnitudes: &parent, first_slice: 0 }), &[], &mut out);
        assert_eq!(out, [3, 3, 4, 4, 4]);
    }
}
