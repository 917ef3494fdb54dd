//! Pairwise nearest neighbours: every vector is a cluster. The two clusters whose union adds least distortion are
//! united, until there are as many as codewords are wanted (Equitz 1989).
//!
//! Only pairs within one bucket of a k-d tree are considered. The better half of the buckets' best unions are carried
//! out before the tree is rebuilt (Equitz's fast form, section IV). So a pass takes time proportional to n·log n and
//! leaves a sixteenth fewer clusters. If there are more vectors than [`MOST`], a seeded choice of that many takes part.

use cvr_core::codec::{Cancelled, Progress};

use crate::{Vectors, sample};

/// Vectors that take part, at most.
pub const MOST: usize = 1 << 16;
/// Most clusters in a bucket. One pair per bucket is considered.
const BUCKET: usize = 8;

/// The remaining clusters: weights, and concatenated means.
struct Clusters {
    dimension: usize,
    weights: Vec<f64>,
    means: Vec<f32>,
}

/// A union of two clusters and the distortion that it adds.
struct Union {
    cost: f64,
    kept: u32,
    gone: u32,
}

/// At most `size` means of clusters, concatenated, ordered by the first vector of each.
///
/// # Errors
/// When `run` was cancelled.
///
/// # Panics
/// When there are no vectors, or `size` is zero.
pub fn unite(vectors: &Vectors, size: usize, seed: u64, run: &Progress<'_>) -> Result<Vec<f64>, Cancelled> {
    assert!(!vectors.is_empty() && size > 0, "nothing to unite");
    let mut clusters = Clusters::of(vectors, size.max(MOST), seed);
    while clusters.weights.len() > size {
        run.advance(0)?;
        let mut members: Vec<u32> = (0..clusters.weights.len() as u32).collect();
        let mut unions = clusters.best_unions(&mut members);
        unions.sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost).then(a.kept.cmp(&b.kept)));
        unions.truncate(unions.len().div_ceil(2).min(clusters.weights.len() - size));
        clusters.carry_out(&unions);
    }
    Ok(clusters.means.into_iter().map(f64::from).collect())
}

impl Clusters {
    fn of(vectors: &Vectors, most: usize, seed: u64) -> Self {
        let dimension = vectors.dimension();
        let mut clusters = Self { dimension, weights: Vec::new(), means: Vec::new() };
        for i in sample::choose(vectors.len() as u64, most as u64, seed) {
            clusters.weights.push(vectors.weight(i as usize));
            clusters.means.extend_from_slice(vectors.vector(i as usize));
        }
        clusters
    }

    fn mean(&self, i: u32) -> &[f32] {
        &self.means[i as usize * self.dimension..][..self.dimension]
    }

    /// The best union of each bucket. Sorts the members into buckets.
    fn best_unions(&self, members: &mut [u32]) -> Vec<Union> {
        if members.len() <= BUCKET {
            members.sort_unstable();
            return self.best(members).into_iter().collect();
        }
        let s = self.widest(members);
        let middle = members.len() / 2;
        let key = |i: &u32| self.mean(*i)[s];
        members.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        let (low, high) = members.split_at_mut(middle);
        let (mut unions, more) = if low.len() > 16 * BUCKET {
            rayon::join(|| self.best_unions(low), || self.best_unions(high))
        } else {
            (self.best_unions(low), self.best_unions(high))
        };
        unions.extend(more);
        unions
    }

    /// The component of largest variance, the first of equals. It examines at most 256 members, evenly spread.
    fn widest(&self, members: &[u32]) -> usize {
        let some = || members.iter().step_by(members.len().div_ceil(256));
        let first = self.mean(members[0]);
        let (mut sums, mut squares) = (vec![0.0_f64; self.dimension], vec![0.0_f64; self.dimension]);
        for i in some() {
            for (((sum, square), x), o) in sums.iter_mut().zip(&mut squares).zip(self.mean(*i)).zip(first) {
                let x = f64::from(*x) - f64::from(*o);
                *sum += x;
                *square += x * x;
            }
        }
        let count = some().count() as f64;
        let variance = |s: &usize| squares[*s] - sums[*s] * sums[*s] / count;
        let widest = (0..self.dimension).rev().max_by(|a, b| variance(a).total_cmp(&variance(b)));
        widest.unwrap_or(0)
    }

    /// The union of least cost, the first of equals.
    fn best(&self, members: &[u32]) -> Option<Union> {
        let mut best: Option<Union> = None;
        for (a, &kept) in members.iter().enumerate() {
            for &gone in &members[a + 1..] {
                let cost = self.cost(kept, gone);
                if best.as_ref().is_none_or(|b| cost < b.cost) {
                    best = Some(Union { cost, kept, gone });
                }
            }
        }
        best
    }

    /// Distortion that a union adds: `w₁ w₂ / (w₁ + w₂) · ‖m₁ − m₂‖²` (Equitz 1989, equation 5).
    fn cost(&self, a: u32, b: u32) -> f64 {
        let (wa, wb) = (self.weights[a as usize], self.weights[b as usize]);
        wa * wb / (wa + wb) * crate::distance::squared(self.mean(a), self.mean(b), None)
    }

    fn carry_out(&mut self, unions: &[Union]) {
        let mut gone = vec![false; self.weights.len()];
        for union in unions {
            let (a, b) = (union.kept as usize, union.gone as usize);
            let (wa, wb) = (self.weights[a], self.weights[b]);
            for s in 0..self.dimension {
                let (x, y) = (self.means[a * self.dimension + s], self.means[b * self.dimension + s]);
                let mean = (wa * f64::from(x) + wb * f64::from(y)) / (wa + wb);
                self.means[a * self.dimension + s] = mean as f32;
            }
            self.weights[a] = wa + wb;
            gone[b] = true;
        }
        let stay: Vec<usize> = (0..gone.len()).filter(|i| !gone[*i]).collect();
        self.means = stay.iter().flat_map(|i| self.mean(*i as u32)).copied().collect();
        self.weights = stay.iter().map(|i| self.weights[*i]).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(count: usize, dimension: usize) -> Vectors {
        let value = |i: usize| ((i as u32).wrapping_mul(0x9e37_79b9) >> 16) as f32;
        Vectors::of_rows(dimension, (0..count * dimension).map(value).collect())
    }

    #[test]
    fn clusters_that_lie_apart_are_found() {
        let centres = [[0.0_f32, 0.0], [90.0, 0.0], [0.0, 70.0], [50.0, 50.0]];
        let mut vectors = Vectors::new(2);
        for i in 0..200_u8 {
            let [x, y] = centres[usize::from(i % 4)];
            vectors.push(&[x + f32::from(i % 7) / 7.0, y + f32::from(i % 5) / 5.0], 1.0);
        }
        let means = unite(&vectors, 4, 1, &Progress::silent()).unwrap();
        assert_eq!(means.len(), 8);
        for [x, y] in centres {
            let near = |m: &[f64]| {
                (m[0] - f64::from(x) - 0.5).abs() < 0.5 && (m[1] - f64::from(y) - 0.5).abs() < 0.5
            };
            assert!(means.chunks_exact(2).any(near), "no cluster at {x}, {y}");
        }
    }

    #[test]
    fn a_small_set_is_united_as_by_hand() {
        // One bucket: 1 and 2 unite (0.5), then 10 and 12 (2.0) before 1.5 and 4 (4.2).
        let vectors = Vectors::of_rows(1, vec![1.0, 2.0, 4.0, 10.0, 12.0]);
        let left = |size| unite(&vectors, size, 1, &Progress::silent()).unwrap();
        assert_eq!(left(5), [1.0, 2.0, 4.0, 10.0, 12.0]);
        assert_eq!(left(4), [1.5, 4.0, 10.0, 12.0]);
        assert_eq!(left(3), [1.5, 4.0, 11.0]);
        let mut weighted = Vectors::new(1);
        [(1.0, 9.0), (2.0, 9.0), (4.0, 0.5)].iter().for_each(|(x, w)| weighted.push(&[*x], *w));
        assert_eq!(unite(&weighted, 2, 1, &Progress::silent()).unwrap()[0], 1.0, "weights count");
    }

    #[test]
    fn any_number_of_threads_gives_the_same_clusters() {
        let vectors = noise(5000, 3);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| unite(&vectors, 60, 1, &Progress::silent()).unwrap())
        };
        let one = on(1);
        assert_eq!(one.len(), 180);
        assert!(one == on(2) && one == on(4));
    }
}
