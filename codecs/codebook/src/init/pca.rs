//! PCA splits: the cell of largest distortion is cut at its mean, perpendicular to its principal axis, until there are
//! enough cells (Schneider and Westermann 2003).
//!
//! The next few cells are cut in parallel, before it is known which cell will be the worst. A cut depends only on its
//! cell. Unused cuts are discarded.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use cvr_core::codec::{Cancelled, Progress};
use rayon::prelude::*;

use crate::Vectors;
use crate::wide::{add_scaled, dot, dot_single, subtract, wide};

/// Vectors per task. Sums of tasks are combined in order.
const TASK: usize = 2048;
/// Cells that are cut at the same time.
const AHEAD: usize = 16;
/// Number of vectors from which a principal axis is computed, evenly spread over the cell.
const AXIS_VECTORS: usize = 512;
/// Steps of the power iteration, at most.
const AXIS_STEPS: usize = 12;
/// The axis counts as settled if the squared sine of the angle between two steps is below this.
const AXIS_SETTLED: f32 = 1e-4;

/// Vectors that one codeword will represent.
struct Cell {
    /// Indices of the vectors, ascending.
    members: Vec<u32>,
    /// Number of members in the cells before this one.
    from: usize,
    mean: Vec<f64>,
    /// Weighted squared distance from the mean.
    distortion: f64,
    cut: Cut,
}

/// State of a cell's cut.
enum Cut {
    Unknown,
    /// All members are equal.
    None,
    Halves(Box<[Cell; 2]>),
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    /// Of equal distortions, the earlier cell counts as larger.
    fn cmp(&self, other: &Self) -> Ordering {
        self.distortion.total_cmp(&other.distortion).then(other.from.cmp(&self.from))
    }
}

/// The cells: their means, and the cell of every vector.
#[derive(Clone, Debug, PartialEq)]
pub struct Split {
    /// The means, concatenated. Fewer than requested if every remaining cell holds one vector.
    pub means: Vec<f64>,
    /// Cell of each vector.
    pub cells: Vec<u32>,
}

/// Cuts the vectors into at most `size` cells.
///
/// # Errors
/// When `run` was cancelled.
///
/// # Panics
/// When there are no vectors.
pub fn split(vectors: &Vectors, size: usize, run: &Progress<'_>) -> Result<Split, Cancelled> {
    assert!(!vectors.is_empty(), "no vectors to split");
    let members: Vec<u32> = (0..vectors.len() as u32).collect();
    let any: Vec<f64> = vectors.vector(0).iter().map(|x| f64::from(*x)).collect();
    let whole = sums_of(vectors, &members, &any).cell(vectors, members, 0, &any);
    let mut open = BinaryHeap::from([whole]);
    let mut closed: Vec<Cell> = Vec::new();
    while open.len() + closed.len() < size
        && let Some(worst) = open.pop()
    {
        match worst.cut {
            Cut::Halves(halves) => open.extend(*halves),
            Cut::None => closed.push(worst),
            Cut::Unknown => {
                run.advance(0)?;
                let wanted = AHEAD.min(size - open.len() - closed.len() - 1);
                let mut next = vec![worst];
                while next.len() < wanted
                    && let Some(cell) = open.pop()
                {
                    next.push(cell);
                }
                next.par_iter_mut().for_each(|cell| cell.cut_now(vectors));
                open.extend(next);
            }
        }
    }
    run.advance(0)?;
    closed.extend(open);
    closed.sort_unstable_by_key(|cell| cell.from);
    let mut cells = vec![0; vectors.len()];
    for (k, cell) in closed.iter().enumerate() {
        cell.members.iter().for_each(|i| cells[*i as usize] = k as u32);
    }
    Ok(Split { means: closed.into_iter().flat_map(|cell| cell.mean).collect(), cells })
}

/// Sums over some vectors of their differences from a point.
struct Sums {
    weight: f64,
    differences: Vec<f64>,
    squares: f64,
}

impl Sums {
    fn none(dimension: usize) -> Self {
        Self { weight: 0.0, differences: vec![0.0; dimension], squares: 0.0 }
    }

    #[inline(always)]
    fn add(&mut self, weight: f64, differences: &[f64]) {
        self.weight += weight;
        self.squares += weight * dot(differences, differences);
        add_scaled(&mut self.differences, weight, differences);
    }

    fn join(mut self, other: &Self) -> Self {
        self.weight += other.weight;
        self.squares += other.squares;
        add_scaled(&mut self.differences, 1.0, &other.differences);
        self
    }

    /// The cell of these vectors. Differences were taken from `point`.
    fn cell(self, vectors: &Vectors, members: Vec<u32>, from: usize, point: &[f64]) -> Cell {
        if let [one] = members[..] {
            let mean = vectors.vector(one as usize).iter().map(|x| f64::from(*x)).collect();
            return Cell { members, from, mean, distortion: 0.0, cut: Cut::None };
        }
        let shift: Vec<f64> = self.differences.iter().map(|d| d / self.weight).collect();
        let distortion = (self.squares - dot(&self.differences, &shift)).max(0.0);
        let mean = point.iter().zip(shift).map(|(p, s)| p + s).collect();
        Cell { members, from, mean, distortion, cut: Cut::Unknown }
    }
}

/// Sums over the members: in order within a task, then over tasks in order.
fn sums_of(vectors: &Vectors, members: &[u32], point: &[f64]) -> Sums {
    let task = |members: &[u32]| {
        wide(|| {
            let (mut sums, mut differences) = (Sums::none(point.len()), vec![0.0; point.len()]);
            for &i in members {
                subtract(vectors.vector(i as usize), point, &mut differences);
                sums.add(vectors.weight(i as usize), &differences);
            }
            sums
        })
    };
    let parts: Vec<Sums> = members.par_chunks(TASK).map(task).collect();
    parts.iter().fold(Sums::none(point.len()), Sums::join)
}

/// Members on both sides of a cut, with their sums.
struct Sides {
    members: [Vec<u32>; 2],
    sums: [Sums; 2],
}

impl Sides {
    fn none(dimension: usize) -> Self {
        Self { members: [Vec::new(), Vec::new()], sums: [Sums::none(dimension), Sums::none(dimension)] }
    }

    fn join(self, other: &Self) -> Self {
        let [mut low, mut high] = self.members;
        low.extend_from_slice(&other.members[0]);
        high.extend_from_slice(&other.members[1]);
        let [a, b] = self.sums;
        Self { members: [low, high], sums: [a.join(&other.sums[0]), b.join(&other.sums[1])] }
    }
}

impl Cell {
    fn cut_now(&mut self, vectors: &Vectors) {
        if !matches!(self.cut, Cut::Unknown) {
            return;
        }
        let sides = if self.distortion > 0.0 { self.sides(vectors) } else { None };
        self.cut = sides.map_or(Cut::None, |sides| {
            let [low, high] = sides.members;
            let [of_low, of_high] = sides.sums;
            let middle = self.from + low.len();
            let low = of_low.cell(vectors, low, self.from, &self.mean);
            let high = of_high.cell(vectors, high, middle, &self.mean);
            Cut::Halves(Box::new([low, high]))
        });
    }

    /// Members at or below the mean along the principal axis, and those above. `None` if all are equal.
    fn sides(&self, vectors: &Vectors) -> Option<Sides> {
        let axis = principal_axis(vectors, &self.members, &self.mean);
        let sides = self.parted(vectors, |_, differences| dot(differences, &axis) > 0.0);
        if sides.members.iter().all(|side| !side.is_empty()) {
            return Some(sides);
        }
        // The axis is lost in rounding, so the widest component is cut in the middle.
        let ends = |s: usize| {
            let component = |i: &u32| vectors.vector(*i as usize)[s];
            self.members.iter().map(component).fold((f32::MAX, f32::MIN), |(a, b), v| (a.min(v), b.max(v)))
        };
        let width = |s: &usize| {
            let (low, high) = ends(*s);
            f64::from(high) - f64::from(low)
        };
        let widest = (0..self.mean.len()).rev().max_by(|a, b| width(a).total_cmp(&width(b)))?;
        let (low, high) = ends(widest);
        let middle = f64::midpoint(low.into(), high.into());
        (low < high).then(|| self.parted(vectors, |vector, _| f64::from(vector[widest]) > middle))
    }

    /// The members of each side. `is_upper` gets a vector and its difference from the mean.
    fn parted(&self, vectors: &Vectors, is_upper: impl Fn(&[f32], &[f64]) -> bool + Sync) -> Sides {
        let dimension = self.mean.len();
        let task = |members: &[u32]| {
            wide(|| {
                let (mut sides, mut differences) = (Sides::none(dimension), vec![0.0; dimension]);
                for &i in members {
                    let vector = vectors.vector(i as usize);
                    subtract(vector, &self.mean, &mut differences);
                    let side = usize::from(is_upper(vector, &differences));
                    sides.members[side].push(i);
                    sides.sums[side].add(vectors.weight(i as usize), &differences);
                }
                sides
            })
        };
        if self.members.len() <= TASK {
            return task(&self.members);
        }
        let parts: Vec<Sides> = self.members.par_chunks(TASK).map(task).collect();
        parts.iter().fold(Sides::none(dimension), Sides::join)
    }
}

/// The direction of largest variance, with length 1, by power iteration. A step needs two products per component. A
/// decomposition of the covariance would need memory of the squared dimension. Single precision is enough, because any
/// axis near it cuts as well.
fn principal_axis(vectors: &Vectors, members: &[u32], mean: &[f64]) -> Vec<f64> {
    let dimension = mean.len();
    let rows = centred(vectors, members, mean);
    let axis = wide(|| {
        // The farthest member is a direction that the cell certainly extends in.
        let length = |row: &&[f32]| dot_single(row, row);
        let farthest = rows.chunks_exact(dimension).rev().max_by(|a, b| length(a).total_cmp(&length(b)));
        let mut axis = farthest.map_or_else(|| vec![1.0; dimension], <[f32]>::to_vec);
        normalise(&mut axis);
        let mut next = vec![0.0; dimension];
        for _ in 0..AXIS_STEPS {
            next.fill(0.0);
            for row in rows.chunks_exact(dimension) {
                let along = dot_single(row, &axis);
                next.iter_mut().zip(row).for_each(|(sum, d)| *sum += along * d);
            }
            normalise(&mut next);
            let cosine = dot_single(&next, &axis);
            std::mem::swap(&mut axis, &mut next);
            if 1.0 - cosine * cosine < AXIS_SETTLED {
                break;
            }
        }
        axis
    });
    axis.into_iter().map(f64::from).collect()
}

/// Differences of some members from the mean, times the square root of their weights, scaled to at most 1.
fn centred(vectors: &Vectors, members: &[u32], mean: &[f64]) -> Vec<f32> {
    let dimension = mean.len();
    wide(|| {
        let some = members.iter().step_by(members.len().div_ceil(AXIS_VECTORS));
        let mut rows = vec![0.0; some.len() * dimension];
        for (&i, row) in some.zip(rows.chunks_exact_mut(dimension)) {
            subtract(vectors.vector(i as usize), mean, row);
            let root = vectors.weight(i as usize).sqrt();
            row.iter_mut().for_each(|d| *d *= root);
        }
        let largest = rows.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        let scale = if largest > 0.0 { 1.0 / largest } else { 0.0 };
        rows.into_iter().map(|d| (d * scale) as f32).collect()
    })
}

/// Scales to length 1. It divides by the largest component first, so that no square overflows. Zero stays zero.
#[inline(always)]
fn normalise(axis: &mut [f32]) {
    let largest = axis.iter().fold(0.0, |m: f32, a| m.max(a.abs()));
    if largest > 0.0 {
        axis.iter_mut().for_each(|a| *a /= largest);
        let length = dot_single(axis, axis).sqrt();
        axis.iter_mut().for_each(|a| *a /= length);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(i: usize) -> f64 {
        let mut h = (i as u32).wrapping_mul(0x9e37_79b9);
        h = (h ^ (h >> 15)).wrapping_mul(0x85eb_ca6b);
        f64::from(h ^ (h >> 13)) / f64::from(u32::MAX) - 0.5
    }

    /// 3000 vectors of 5 components, longest along a slanted axis.
    fn slanted() -> Vectors {
        let value =
            |i: usize, s: usize| noise(i) * [3.0, -2.0, 5.0, 0.5, 1.0][s] + noise(7 * i + s + 99_991) + 20.0;
        let mut vectors = Vectors::new(5);
        for i in 0..3000 {
            let vector: Vec<f32> = (0..5).map(|s| value(i, s) as f32).collect();
            vectors.push(&vector, 1.0 + (i % 3) as f64);
        }
        vectors
    }

    #[test]
    fn the_axis_is_that_of_an_eigen_decomposition() {
        let vectors = slanted();
        let order: Vec<u32> = (0..vectors.len() as u32).collect();
        let mean = sums_of(&vectors, &order, &[0.0; 5]).cell(&vectors, order.clone(), 0, &[0.0; 5]).mean;
        let mut covariance = nalgebra::DMatrix::<f64>::zeros(5, 5);
        for i in 0..vectors.len() {
            let d: Vec<f64> = vectors.vector(i).iter().zip(&mean).map(|(x, m)| f64::from(*x) - m).collect();
            let d = nalgebra::DVector::from_vec(d);
            covariance += vectors.weight(i) * &d * d.transpose();
        }
        let eigen = covariance.symmetric_eigen();
        let largest = eigen.eigenvalues.imax();
        let axis = nalgebra::DVector::from_vec(principal_axis(&vectors, &order, &mean));
        let cosine = axis.dot(&eigen.eigenvectors.column(largest)).abs();
        assert!(cosine > 0.999, "{cosine}");
    }

    #[test]
    fn every_distinct_vector_gets_a_cell_where_there_are_enough() {
        let mut vectors = Vectors::new(2);
        for i in 0..50_u8 {
            vectors.push(&[f32::from(i % 10), f32::from(i / 10) * 1e-3], 1.0);
        }
        let means = split(&vectors, 64, &Progress::silent()).unwrap().means;
        assert_eq!(means.len(), 100);
        let distortion: f64 = means
            .chunks_exact(2)
            .map(|m| {
                let near = |i| vectors.vector(i).iter().zip(m).all(|(a, b)| f64::from(*a) == *b);
                f64::from(u8::from(!(0..50).any(near)))
            })
            .sum();
        assert_eq!(distortion, 0.0, "a mean is no vector");
        assert_eq!(split(&vectors, 7, &Progress::silent()).unwrap().means.len(), 14);
    }

    #[test]
    fn equal_vectors_are_one_cell() {
        let vectors = Vectors::of_rows(3, [0.1, 0.7, 1e9].repeat(11));
        let means = split(&vectors, 8, &Progress::silent()).unwrap().means;
        assert_eq!(means.len(), 3);
    }

    #[test]
    fn any_number_of_threads_gives_the_same_cells() {
        let vectors = slanted();
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| split(&vectors, 100, &Progress::silent()).unwrap())
        };
        let one = on(1);
        assert_eq!(one, on(2));
        assert_eq!(one, on(4));
    }
}
