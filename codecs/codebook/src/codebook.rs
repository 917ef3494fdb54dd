//! Codewords in stored and decoded form.

use std::collections::HashMap;

use crate::Quantiser;
use crate::pack::BitPacker;

/// Codewords of one dimension, under one quantiser.
#[derive(Clone, Debug, PartialEq)]
pub struct Codebook {
    dimension: usize,
    quantiser: Quantiser,
    codes: Vec<u16>,
    values: Vec<f32>,
}

impl Codebook {
    /// The codewords nearest to `vectors` (which are concatenated). Of equal codewords the first is kept.
    ///
    /// # Panics
    /// When `vectors` is no whole number of vectors.
    #[must_use]
    pub fn nearest_to(vectors: &[f64], dimension: usize, quantiser: Quantiser) -> Self {
        Self::placed(vectors, dimension, quantiser).0
    }

    /// As many codewords as `vectors` (one after the other), the nearest to each, equal ones kept: a codeword has the number
    /// of its vector.
    ///
    /// # Panics
    /// When `vectors` is no whole number of vectors.
    #[must_use]
    pub fn one_for_each(vectors: &[f64], dimension: usize, quantiser: Quantiser) -> Self {
        assert!(dimension > 0 && vectors.len().is_multiple_of(dimension), "no whole number of vectors");
        let mut codebook = Self { dimension, quantiser, codes: Vec::new(), values: Vec::new() };
        codebook.push(&vectors.iter().map(|v| quantiser.code(*v)).collect::<Vec<_>>());
        codebook
    }

    /// As [`Codebook::nearest_to`], and where each of the vectors went.
    pub(crate) fn placed(vectors: &[f64], dimension: usize, quantiser: Quantiser) -> (Self, Vec<u32>) {
        assert!(dimension > 0 && vectors.len().is_multiple_of(dimension), "no whole number of vectors");
        let mut codebook = Self { dimension, quantiser, codes: Vec::new(), values: Vec::new() };
        let (mut seen, mut places) = (HashMap::new(), Vec::with_capacity(vectors.len() / dimension));
        for vector in vectors.chunks_exact(dimension) {
            let codes: Vec<u16> = vector.iter().map(|v| quantiser.code(*v)).collect();
            let next = codebook.size() as u32;
            places.push(*seen.entry(codes).or_insert_with_key(|codes| {
                codebook.push(codes);
                next
            }));
        }
        (codebook, places)
    }

    /// Number of codewords.
    #[must_use]
    pub fn size(&self) -> usize {
        self.codes.len() / self.dimension
    }

    /// Components of a codeword.
    #[must_use]
    pub const fn dimension(&self) -> usize {
        self.dimension
    }

    /// How codes become values.
    #[must_use]
    pub const fn quantiser(&self) -> Quantiser {
        self.quantiser
    }

    /// All codes, one codeword after the other.
    #[must_use]
    pub fn codes(&self) -> &[u16] {
        &self.codes
    }

    /// Codes of codeword `k`.
    ///
    /// # Panics
    /// When there is none.
    #[must_use]
    pub fn codes_of(&self, k: usize) -> &[u16] {
        &self.codes[k * self.dimension..(k + 1) * self.dimension]
    }

    /// All values, one codeword after the other.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Values of codeword `k`.
    ///
    /// # Panics
    /// When there is none.
    #[must_use]
    pub fn codeword(&self, k: usize) -> &[f32] {
        &self.values[k * self.dimension..(k + 1) * self.dimension]
    }

    /// All codes in words, as a stream and a shader hold them.
    #[must_use]
    pub fn packed(&self) -> Vec<u32> {
        let (mut packer, mut words) = (BitPacker::new(self.quantiser.bits()), Vec::new());
        self.codes.iter().for_each(|code| packer.push((*code).into(), &mut words));
        packer.flush(&mut words);
        words
    }

    /// Appends a codeword.
    pub(crate) fn push(&mut self, codes: &[u16]) {
        self.codes.extend_from_slice(codes);
        self.values.extend(codes.iter().map(|c| self.quantiser.value((*c).into())));
    }

    /// Only the codewords that `keep` names, in their order.
    #[must_use]
    pub(crate) fn kept(&self, keep: impl Fn(usize) -> bool) -> Self {
        let mut kept = Self { codes: Vec::new(), values: Vec::new(), ..*self };
        for (k, codes) in self.codes.chunks_exact(self.dimension).enumerate() {
            if keep(k) {
                kept.push(codes);
            }
        }
        kept
    }

    /// Bits of an index: the fewest that distinguish all codewords, at least one.
    #[must_use]
    pub fn index_bits(&self) -> u32 {
        index_bits(self.size())
    }
}

/// Bits of an index into `size` codewords: `ceil(log2(size))`, at least one.
#[must_use]
pub fn index_bits(size: usize) -> u32 {
    size.next_power_of_two().trailing_zeros().max(1)
}
