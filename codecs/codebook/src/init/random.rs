//! Randomly drawn training vectors. No two are equal.

use crate::{Vectors, sample};

/// At most `size` distinct vectors, concatenated. All are equally likely, regardless of weight. [`sample::choose`]
/// makes the choice. All vectors if there are no more than `size`.
///
/// # Panics
/// When there are no vectors.
#[must_use]
pub fn draw(vectors: &Vectors, size: usize, seed: u64) -> Vec<f64> {
    assert!(!vectors.is_empty(), "no vectors to draw from");
    let merged = vectors.merged();
    let chosen = sample::choose(merged.len() as u64, size as u64, seed);
    chosen.into_iter().flat_map(|i| merged.vector(i as usize)).map(|x| f64::from(*x)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_distinct_and_those_of_the_seed() {
        let values = (0..400).flat_map(|i| [f32::from(i as u8 / 4), 3.0]).collect();
        let vectors = Vectors::of_rows(2, values);
        let drawn = draw(&vectors, 20, 5);
        let mut first: Vec<f64> = drawn.chunks_exact(2).map(|v| v[0]).collect();
        first.dedup();
        assert_eq!((first.len(), drawn.len()), (20, 40), "a vector was drawn twice");
        assert_eq!(drawn, draw(&vectors, 20, 5));
        assert_ne!(drawn, draw(&vectors, 20, 6));
        assert_eq!(draw(&vectors, 1000, 5).len(), 2 * 64, "400 vectors of 64 kinds");
    }
}
