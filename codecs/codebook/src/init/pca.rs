//! PCA splits: the cell of largest distortion is cut at its mean, across its principal axis, until there are as many
//! cells as codewords (Schneider and Westermann 2003).

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use cvr_core::codec::{Cancelled, Progress};
use rayon::prelude::*;

use crate::Vectors;

/// Vectors of a task; sums over tasks are combined in order.
const TASK: usize = 2048;
/// Vectors from which a principal axis is found, evenly spread over the cell.
const AXIS_VECTORS: usize = 4096;
/// Steps of the power iteration, at most.
const AXIS_STEPS: usize = 24;
/// Squared sine of the angle between two steps below which the axis has settled.
const AXIS_SETTLED: f64 = 1e-6;

/// Vectors that one codeword will stand for.
struct Cell {
    /// Where their numbers stand in the order.
    from: usize,
    to: usize,
    mean: Vec<f64>,
    /// Weighted squared distance from the mean.
    distortion: f64,
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
    /// Of equal distortions the cell that comes first in the order is the larger.
    fn cmp(&self, other: &Self) -> Ordering {
        self.distortion.total_cmp(&other.distortion).then(other.from.cmp(&self.from))
    }
}

/// Means of at most `size` cells, one after the other; fewer where cells are left that hold one vector each.
///
/// # Errors
/// When `run` was cancelled.
///
/// # Panics
/// When there are no vectors.
pub fn split(vectors: &Vectors, size: usize, run: &Progress<'_>) -> Result<Vec<f64>, Cancelled> {
    assert!(!vectors.is_empty(), "no vectors to split");
    let mut order: Vec<u32> = (0..vectors.len() as u32).collect();
    let mut open = BinaryHeap::from([cell(vectors, &order, 0, order.len())]);
    let mut closed = Vec::new();
    while open.len() + closed.len() < size
        && let Some(worst) = open.pop()
    {
        let range = worst.from..worst.to;
        let cut = if worst.distortion > 0.0 { cut(vectors, &mut order[range], &worst.mean) } else { None };
        let Some(lower) = cut else {
            closed.push(worst);
            continue;
        };
        let middle = worst.from + lower;
        open.push(cell(vectors, &order, worst.from, middle));
        open.push(cell(vectors, &order, middle, worst.to));
        if (worst.to - worst.from) > TASK {
            run.advance(0)?;
        }
    }
    run.advance(0)?;
    closed.extend(open);
    closed.sort_unstable_by_key(|cell| cell.from);
    Ok(closed.into_iter().flat_map(|cell| cell.mean).collect())
}

fn cell(vectors: &Vectors, order: &[u32], from: usize, to: usize) -> Cell {
    let members = &order[from..to];
    let dimension = vectors.dimension();
    let weight = |i: &u32| vectors.weight(*i as usize);
    let total: f64 = members.iter().map(weight).sum();
    let sums = summed(members, dimension, |i, sums| {
        let weight = weight(&i);
        for (sum, x) in sums.iter_mut().zip(vectors.vector(i as usize)) {
            *sum += weight * f64::from(*x);
        }
    });
    let mean: Vec<f64> = sums.into_iter().map(|sum| sum / total).collect();
    let distortion = summed(members, 1, |i, sums| {
        let square = |(x, m): (&f32, &f64)| (f64::from(*x) - m).powi(2);
        sums[0] += weight(&i) * vectors.vector(i as usize).iter().zip(&mean).map(square).sum::<f64>();
    });
    // Equal vectors differ from their mean by rounding alone.
    let distortion = if members.len() == 1 { 0.0 } else { distortion[0] };
    Cell { from, to, mean, distortion }
}

/// Sums of `width` numbers over the members: in order within a task, then over the tasks in order.
fn summed(members: &[u32], width: usize, add: impl Fn(u32, &mut [f64]) + Sync) -> Vec<f64> {
    let task = |members: &[u32]| {
        let mut sums = vec![0.0; width];
        members.iter().for_each(|i| add(*i, &mut sums));
        sums
    };
    if members.len() <= TASK {
        return task(members);
    }
    let parts: Vec<Vec<f64>> = members.par_chunks(TASK).map(task).collect();
    let mut parts = parts.into_iter();
    let first = parts.next().unwrap_or_default();
    parts.fold(first, |mut sums, part| {
        sums.iter_mut().zip(part).for_each(|(sum, more)| *sum += more);
        sums
    })
}

/// Reorders the members: those at or below the mean along the principal axis first. Returns how many these are;
/// `None` where all members are equal.
fn cut(vectors: &Vectors, members: &mut [u32], mean: &[f64]) -> Option<usize> {
    let axis = principal_axis(vectors, members, mean);
    let along = |i: u32| {
        let terms = vectors.vector(i as usize).iter().zip(mean).zip(&axis);
        terms.map(|((x, m), a)| (f64::from(*x) - m) * a).sum::<f64>()
    };
    let upper: Vec<bool> = members.par_iter().with_min_len(TASK).map(|i| along(*i) > 0.0).collect();
    let lower = partition(members, &upper);
    if lower > 0 && lower < members.len() {
        return Some(lower);
    }
    // The axis is lost in rounding: cut the widest component in the middle.
    let ends = |s: usize| {
        let component = |i: &u32| vectors.vector(*i as usize)[s];
        members.iter().map(component).fold((f32::MAX, f32::MIN), |(a, b), v| (a.min(v), b.max(v)))
    };
    let width = |s: &usize| {
        let (low, high) = ends(*s);
        f64::from(high) - f64::from(low)
    };
    let widest = (0..mean.len()).rev().max_by(|a, b| width(a).total_cmp(&width(b)))?;
    let (low, high) = ends(widest);
    if low >= high {
        return None;
    }
    let middle = f64::midpoint(low.into(), high.into());
    let upper: Vec<bool> =
        members.iter().map(|i| f64::from(vectors.vector(*i as usize)[widest]) > middle).collect();
    Some(partition(members, &upper))
}

/// Members that are not upper first; both parts keep their order.
fn partition(members: &mut [u32], upper: &[bool]) -> usize {
    let side = |wanted| members.iter().zip(upper).filter(move |(_, u)| **u == wanted).map(|(i, _)| *i);
    let sorted: Vec<u32> = side(false).chain(side(true)).collect();
    members.copy_from_slice(&sorted);
    upper.iter().filter(|u| !**u).count()
}

/// The direction of largest variance, of length 1, by power iteration: a step costs two products per component, where a
/// decomposition of the covariance would need the square of the dimension in memory. It need not be exact: any axis
/// near it cuts as well.
fn principal_axis(vectors: &Vectors, members: &[u32], mean: &[f64]) -> Vec<f64> {
    let some: Vec<u32> = members.iter().copied().step_by(members.len().div_ceil(AXIS_VECTORS)).collect();
    let centred = |i: u32| {
        let vector = vectors.vector(i as usize);
        vector.iter().zip(mean).map(|(x, m)| f64::from(*x) - m)
    };
    // The farthest member is a direction that the cell certainly extends in.
    let length = |i: &u32| centred(*i).map(|d| d * d).sum::<f64>();
    let farthest = some.iter().rev().max_by(|a, b| length(a).total_cmp(&length(b)));
    let mut axis: Vec<f64> = farthest.map_or_else(|| vec![1.0; mean.len()], |i| centred(*i).collect());
    normalise(&mut axis);
    for _ in 0..AXIS_STEPS {
        let mut next = summed(&some, mean.len(), |i, sums| {
            let along: f64 = centred(i).zip(&axis).map(|(d, a)| d * a).sum();
            let along = along * vectors.weight(i as usize);
            sums.iter_mut().zip(centred(i)).for_each(|(sum, d)| *sum += along * d);
        });
        normalise(&mut next);
        let cosine: f64 = next.iter().zip(&axis).map(|(a, b)| a * b).sum();
        axis = next;
        if 1.0 - cosine * cosine < AXIS_SETTLED {
            break;
        }
    }
    axis
}

/// Scales to length 1, over the largest component first, so that no square overflows; leaves zero as it is.
fn normalise(axis: &mut [f64]) {
    let largest = axis.iter().fold(0.0, |m: f64, a| m.max(a.abs()));
    if largest > 0.0 {
        axis.iter_mut().for_each(|a| *a /= largest);
        let length = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
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
        let mean = cell(&vectors, &order, 0, order.len()).mean;
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
        let means = split(&vectors, 64, &Progress::silent()).unwrap();
        assert_eq!(means.len(), 100);
        let distortion: f64 = means
            .chunks_exact(2)
            .map(|m| {
                let near = |i| vectors.vector(i).iter().zip(m).all(|(a, b)| f64::from(*a) == *b);
                f64::from(u8::from(!(0..50).any(near)))
            })
            .sum();
        assert_eq!(distortion, 0.0, "a mean is no vector");
        assert_eq!(split(&vectors, 7, &Progress::silent()).unwrap().len(), 14);
    }

    #[test]
    fn equal_vectors_are_one_cell() {
        let vectors = Vectors::of_rows(3, [0.1, 0.7, 1e9].repeat(11));
        let means = split(&vectors, 8, &Progress::silent()).unwrap();
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
