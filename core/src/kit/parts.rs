//! Tensors in parts of equal length along their slowest axis: frames, or tables.

use std::borrow::Cow;

use crate::codec::{DecodeError, Resource};
use crate::container::{Element, EncodedVolume, Tensor};

/// A tensor of words in parts along its slowest axis. It is checked once.
#[derive(Clone, Debug)]
pub struct PartedTensor {
    name: &'static str,
    tensor: Tensor,
    part_words: usize,
}

impl PartedTensor {
    /// Opens the tensor `name`. It must have this shape, slowest axis first.
    ///
    /// # Errors
    /// If the tensor is absent, does not hold 32-bit words, or has another shape.
    pub fn open(volume: &EncodedVolume, name: &'static str, shape: &[u64]) -> Result<Self, DecodeError> {
        let tensor = volume.tensor_of_shape(name, Element::U32, shape)?.clone();
        let parts = shape.first().map_or(1, |parts| (*parts as usize).max(1));
        Ok(Self { name, part_words: tensor.words().len() / parts, tensor })
    }

    /// Part `i`.
    ///
    /// # Panics
    /// If there is no such part.
    #[must_use]
    #[inline]
    pub fn part(&self, i: usize) -> &[u32] {
        &self.tensor.words()[i * self.part_words..(i + 1) * self.part_words]
    }

    /// All parts, one after another.
    #[must_use]
    pub fn words(&self) -> &[u32] {
        self.tensor.words()
    }

    /// Part `i` as a buffer of the tensor's name.
    ///
    /// # Panics
    /// If there is no such part.
    #[must_use]
    pub fn resource(&self, i: usize) -> Resource<'_> {
        Resource { name: self.name, words: Cow::Borrowed(self.part(i)) }
    }
}
