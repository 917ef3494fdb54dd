//! Access to decoded frames for the properties.

pub(super) use crate::codec::Decoded;
use crate::volume::{FrameIndex, ReferenceFrames as _};

impl Decoded {
    /// The samples of one frame.
    pub(super) fn values(&self, frame: FrameIndex) -> &[f32] {
        self.frame(frame).unwrap_or(&[])
    }
}

/// A sentence about the first sample in which two frames differ. Zeros of either sign are equal.
pub fn difference(expected: &[f32], actual: &[f32]) -> Option<String> {
    if expected.len() != actual.len() {
        return Some(format!("{} samples instead of {}", actual.len(), expected.len()));
    }
    let (i, (e, a)) = expected.iter().zip(actual).enumerate().find(|(_, (e, a))| e != a)?;
    Some(format!("sample {i} is {a}, expected {e}"))
}
