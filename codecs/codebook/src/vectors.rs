//! The training set.

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

    /// None yet, with room for `count`.
    ///
    /// # Panics
    /// When `dimension` is 0.
    #[must_use]
    pub fn with_room_for(count: usize, dimension: usize) -> Self {
        let empty = Self::new(dimension);
        let values = Vec::with_capacity(count * dimension);
        Self { values, weights: Vec::with_capacity(count), ..empty }
    }

    /// Vectors concatenated in `values`, each with weight 1.
    ///
    /// # Panics
    /// When `values` is no whole number of vectors.
    #[must_use]
    pub fn of_rows(dimension: usize, values: Vec<f32>) -> Self {
        assert!(dimension > 0 && values.len().is_multiple_of(dimension), "no whole number of vectors");
        let weights = vec![1.0; values.len() / dimension];
        Self { dimension, values, weights }
    }

    /// Appends a vector. `weight` is positive and multiplies its squared error.
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

    /// All components, to be changed. They stay finite.
    #[must_use]
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
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

    /// Merges equal vectors at the place of the first, with the sum of their weights. Zeros of both signs are equal.
    #[must_use]
    pub fn merged(&self) -> Self {
        let mut places = Places::for_many(self.len());
        let mut merged = Self::new(self.dimension);
        for (i, vector) in self.values.chunks_exact(self.dimension).enumerate() {
            let hash = hash(vector);
            let equal = |place: usize| merged.vector(place) == vector;
            let place = places.find_or_add(hash, merged.len(), equal);
            if place == merged.len() {
                merged.push(vector, self.weights[i]);
            } else {
                merged.weights[place] += self.weights[i];
            }
        }
        merged
    }

    /// The vectors with indices `order`, in that order.
    #[must_use]
    pub(crate) fn ordered(&self, order: &[u32]) -> Self {
        let mut ordered = Self {
            dimension: self.dimension,
            values: Vec::with_capacity(order.len() * self.dimension),
            weights: Vec::with_capacity(order.len()),
        };
        for &i in order {
            ordered.values.extend_from_slice(self.vector(i as usize));
            ordered.weights.push(self.weights[i as usize]);
        }
        ordered
    }
}

/// A hash table of positions: open addressing, at most half full.
struct Places {
    slots: Vec<(u32, u32)>,
}

impl Places {
    const FREE: u32 = u32::MAX;

    fn for_many(count: usize) -> Self {
        Self { slots: vec![(0, Self::FREE); (2 * count).next_power_of_two().max(2)] }
    }

    /// The position with that hash for which `equal` holds. Else `next`, which is inserted.
    fn find_or_add(&mut self, hash: u64, next: usize, equal: impl Fn(usize) -> bool) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash as usize & mask;
        let tag = (hash >> 32) as u32;
        loop {
            match self.slots[slot] {
                (_, Self::FREE) => {
                    self.slots[slot] = (tag, next as u32);
                    return next;
                }
                (other, place) if other == tag && equal(place as usize) => return place as usize,
                _ => slot = (slot + 1) & mask,
            }
        }
    }
}

/// Equal vectors have equal hashes. Four chains, so that multiplications overlap.
fn hash(vector: &[f32]) -> u64 {
    const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;
    let mix = |h: u64, x: f32| {
        // −0 + 0 = 0.
        let h = (h ^ u64::from((x + 0.0).to_bits())).wrapping_mul(FACTOR);
        h ^ (h >> 29)
    };
    let mut chains = [1_u64, 2, 3, 4];
    let fours = vector.chunks_exact(4);
    let rest = fours.remainder();
    for four in fours {
        chains.iter_mut().zip(four).for_each(|(h, x)| *h = mix(*h, *x));
    }
    chains.iter_mut().zip(rest).for_each(|(h, x)| *h = mix(*h, *x));
    let all = chains.iter().fold(0_u64, |h, chain| (h.rotate_left(23) ^ chain).wrapping_mul(FACTOR));
    all ^ (all >> 32)
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
