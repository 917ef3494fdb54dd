//! Independent scalar quantisers. Every component has its own quantiser, and bits go where the error is largest. The
//! codebook is the points of the product grid that represent most vectors (Gersho and Gray 1992, section 8.2, for the
//! allocation of bits).
//!
//! A component's quantiser grows by a bit when each of its intervals is cut at the mean of its values. The component
//! with the largest remaining error gets the next bit, until vectors lie in as many cells of the grid as codewords are
//! wanted. Only cells with vectors are formed: a full grid of correlated components would be mostly empty.

use std::collections::HashMap;

use cvr_core::codec::{Cancelled, Progress};
use rayon::prelude::*;

use crate::Vectors;

/// Bits that a component takes, at most.
const MOST_BITS: u32 = 16;

/// The quantiser of one component: the interval of every vector.
struct Component {
    bits: u32,
    interval: Vec<u32>,
    /// Mean of the values in each interval.
    levels: Vec<f64>,
    /// Weighted squared error.
    error: f64,
}

/// At most `size` points of the product grid, concatenated: those that represent the largest weight of vectors.
///
/// # Errors
/// When `run` was cancelled.
///
/// # Panics
/// When there are no vectors.
pub fn grid(vectors: &Vectors, size: usize, run: &Progress<'_>) -> Result<Vec<f64>, Cancelled> {
    assert!(!vectors.is_empty(), "no vectors to quantise");
    let one = |s| Component::of(vectors, s, 0, vec![0; vectors.len()], 1);
    let mut components: Vec<Component> = (0..vectors.dimension()).into_par_iter().map(one).collect();
    let (mut cells, mut count) = (vec![0_u32; vectors.len()], 1);
    while count < size {
        run.advance(0)?;
        let open = (0..components.len()).rev().filter(|s| components[*s].bits < MOST_BITS);
        let worst = open.max_by(|a, b| components[*a].error.total_cmp(&components[*b].error));
        let Some(s) = worst.filter(|s| components[*s].error > 0.0) else { break };
        components[s] = components[s].finer(vectors, s);
        let mut places = HashMap::new();
        for (cell, interval) in cells.iter_mut().zip(&components[s].interval) {
            let next = places.len() as u32;
            *cell = *places.entry((*cell, *interval)).or_insert(next);
        }
        count = places.len();
    }
    Ok(heaviest(vectors, &components, &cells, count, size))
}

/// Points of the cells of largest weight, ordered by their first vectors.
fn heaviest(
    vectors: &Vectors,
    components: &[Component],
    cells: &[u32],
    count: usize,
    size: usize,
) -> Vec<f64> {
    let (mut weights, mut firsts) = (vec![0.0; count], vec![usize::MAX; count]);
    for (i, cell) in cells.iter().enumerate() {
        weights[*cell as usize] += vectors.weight(i);
        firsts[*cell as usize] = firsts[*cell as usize].min(i);
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| weights[*b].total_cmp(&weights[*a]).then(firsts[*a].cmp(&firsts[*b])));
    order.truncate(size);
    order.sort_unstable_by_key(|cell| firsts[*cell]);
    let level = |c: &Component, i: usize| c.levels[c.interval[i] as usize];
    order
        .into_iter()
        .flat_map(|cell| {
            components.iter().map({
                let i = firsts[cell];
                move |c| level(c, i)
            })
        })
        .collect()
}

impl Component {
    fn of(vectors: &Vectors, s: usize, bits: u32, interval: Vec<u32>, count: usize) -> Self {
        let value = |i: usize| f64::from(vectors.vector(i)[s]);
        let (mut levels, mut weights) = (vec![0.0; count], vec![0.0; count]);
        for (i, k) in interval.iter().enumerate() {
            levels[*k as usize] += vectors.weight(i) * value(i);
            weights[*k as usize] += vectors.weight(i);
        }
        levels.iter_mut().zip(weights).for_each(|(level, weight)| *level /= weight);
        let square = |(i, k): (usize, &u32)| vectors.weight(i) * (value(i) - levels[*k as usize]).powi(2);
        let error = interval.iter().enumerate().map(square).sum();
        Self { bits, interval, levels, error }
    }

    /// Cuts every interval at its level. Only new intervals that contain a vector are kept.
    fn finer(&self, vectors: &Vectors, s: usize) -> Self {
        let mut names = vec![u32::MAX; 2 * self.levels.len()];
        let mut count = 0;
        let cut = |(i, k): (usize, &u32)| {
            let upper = f64::from(vectors.vector(i)[s]) > self.levels[*k as usize];
            let name = &mut names[2 * *k as usize + usize::from(upper)];
            if *name == u32::MAX {
                *name = count;
                count += 1;
            }
            *name
        };
        let interval = self.interval.iter().enumerate().map(cut).collect();
        Self::of(vectors, s, self.bits + 1, interval, count as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_go_to_the_components_that_vary() {
        // 64 levels along the first component, two close ones along the second.
        let values = (0..640).flat_map(|i| [(i % 64) as f32, (i % 2) as f32 * 0.01]).collect();
        let points = grid(&Vectors::of_rows(2, values), 16, &Progress::silent()).unwrap();
        let mut first: Vec<f64> = points.chunks_exact(2).map(|p| p[0]).collect();
        first.sort_by(f64::total_cmp);
        assert_eq!(first, (0..16).map(|i| f64::from(i) * 4.0 + 1.5).collect::<Vec<_>>());
        assert!(points.chunks_exact(2).all(|p| (p[1] - 0.005).abs() < 1e-9), "the second took a bit");
    }

    #[test]
    fn the_grid_is_thinned_to_the_points_that_stand_for_most() {
        // Eight corners of a square's grid. Those with weight are kept.
        let mut vectors = Vectors::new(3);
        for i in 0..8_u8 {
            let corner = [0, 1, 2].map(|s| f32::from(i >> s & 1));
            vectors.push(&corner, if i % 3 == 0 { 5.0 } else { 1.0 });
        }
        let points = grid(&vectors, 5, &Progress::silent()).unwrap();
        assert_eq!(points.len(), 15);
        for i in [0_u8, 3, 6] {
            let corner = [0, 1, 2].map(|s| f64::from(i >> s & 1));
            assert!(points.chunks_exact(3).any(|p| p == corner), "corner {i} is missing");
        }
    }

    #[test]
    fn there_are_no_more_points_than_vectors() {
        let vectors = Vectors::of_rows(2, [1.0, 5.0, 2.0, 5.0, 1e9, -5.0].repeat(4));
        let points = grid(&vectors, 100, &Progress::silent()).unwrap();
        assert_eq!(points, [1.0, 5.0, 2.0, 5.0, 1e9, -5.0]);
    }
}
