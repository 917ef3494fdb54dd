//! What is wrong with bytes that no encoder has written.

use std::fmt::Display;

use cvr_core::codec::DecodeError;

/// A sentence about a corrupt chunk. It is small, so that inner loops can return it.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Fault(pub &'static str);

impl Fault {
    /// The error of a decoder, which names the part of the stream that is corrupt.
    #[must_use]
    pub fn of(self, part: impl Display) -> DecodeError {
        DecodeError::Corrupt(format!("{part}: {}", self.0))
    }
}

impl From<Fault> for DecodeError {
    fn from(fault: Fault) -> Self {
        Self::Corrupt(fault.0.to_owned())
    }
}
