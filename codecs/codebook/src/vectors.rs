//! The training set.

use std::collections::HashMap;

/// Vectors of one dimension, each with a weight. Components are finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Vectors {
    dimension: usize,
    values: Vec<f32>,
    weights: Vec<f64>,
}

impl Vectors {
    /// No vectors yet.
    ///
    /// # Panics
    /// When `dimension` is zero.
    #[must_use]
    pub fn new(dimension: usize) -> Self {
        assert!(dimension > 0, "vectors need a component");
        Self { dimension, values: Vec::new(), weights: Vec::new() }
    }

    /// Vectors that follow each other in `values`, each of weight 1.
    ///
    /// # Panics
    /// When `values` is no whole number of vectors.
    #[must_use]
    pub fn of_rows(dimension: usize, values: Vec<f32>) -> Self {
        assert!(dimension > 0 && values.len().is_multiple_of(dimension), "no whole number of vectors");
        let weights = vec![1.0; values.len() / dimension];
        Self { dimension, values, weights }
    }

    /// Appends a vector. `weight` is positive: how often its squared error counts.
    ///
    /// # Panics
    /// When `vector` is of another dimension.
    pub fn push(&mut self, vector: &[f32], weight: f64) {
        assert_eq!(vector.len(), self.dimension, "a vector of another dimension");
        debug_assert!(weight > 0.0 && vector.iter().all(|v| v.is_finite()));
        self.values.extend_from_slice(vector);
        self.weights.push(weight);
    }

    /// Appends all of `other`, in order.
    ///
    /// # Panics
    /// When it is of another dimension.
    pub fn append(&mut self, other: &Self) {
        assert_eq!(self.dimension, other.dimension, "vectors of another dimension");
        self.values.extend_from_slice(&other.values);
        self.weights.extend_from_slice(&other.weights);
    }

    /// Components of a vector.
    #[must_use]
    pub const fn dimension(&self) -> usize {
        self.dimension
    }

    /// Number of vectors.
    #[must_use]
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// All components, one vector after the other.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Vector `i`.
    ///
    /// # Panics
    /// When there is none.
    #[must_use]
    pub fn vector(&self, i: usize) -> &[f32] {
        &self.values[i * self.dimension..(i + 1) * self.dimension]
    }

    /// Weight of vector `i`.
    ///
    /// # Panics
    /// When there is none.
    #[must_use]
    pub fn weight(&self, i: usize) -> f64 {
        self.weights[i]
    }

    /// Sum of all weights, in order.
    #[must_use]
    pub fn total_weight(&self) -> f64 {
        self.weights.iter().sum()
    }

    /// Equal vectors become one of their summed weight, where the first of them stood. Zeros of both signs are
    /// equal.
    #[must_use]
    pub fn merged(&self) -> Self {
        let mut places: HashMap<Vec<u32>, usize> = HashMap::with_capacity(self.len());
        let mut merged = Self::new(self.dimension);
        for (i, vector) in self.values.chunks_exact(self.dimension).enumerate() {
            // −0 + 0 = 0.
            let key = vector.iter().map(|v| (v + 0.0).to_bits()).collect();
            let place = *places.entry(key).or_insert(merged.len());
            if place == merged.len() {
                merged.push(vector, self.weights[i]);
            } else {
                merged.weights[place] += self.weights[i];
            }
        }
        merged
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_vectors_merge_where_the_first_stood() {
        let mut vectors = Vectors::new(2);
        for (vector, weight) in
            [([1.0, 2.0], 1.0), ([0.0, -0.0], 0.5), ([1.0, 2.0], 2.0), ([-0.0, 0.0], 0.25), ([2.0, 1.0], 1.0)]
        {
            vectors.push(&vector, weight);
        }
        let merged = vectors.merged();
        assert_eq!(merged.values(), [1.0, 2.0, 0.0, 0.0, 2.0, 1.0]);
        assert_eq!([merged.weight(0), merged.weight(1), merged.weight(2)], [3.0, 0.75, 1.0]);
        assert_eq!(merged.total_weight(), vectors.total_weight());
    }
}
