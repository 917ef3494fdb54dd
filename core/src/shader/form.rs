//! How often the voxel source stands in a shader.
//!
//! A software rasteriser compiles every call as a copy of what it calls. A sample between voxels fetches eight of them, a lit
//! one takes seven such samples, and a codec that is much text (`zfp`) compiles for minutes when it is copied so often. A loop around one
//! call is compiled once, but a device that ends long loops counts its rounds, and a light codec is slower in it. So texts
//! are written out as long as they are short, and looped above a stated length.

use cvr_shaders::{FILTER_LINEAR, FILTER_LINEAR_LOOPED, GRADIENT, GRADIENT_LOOPED, Template};

/// The longest text that is not looped, in [`super::GeneratedShader::inlined_operations`]. llvmpipe compiles it within about two
/// seconds (docs/benchmarks/shader-compile.md).
pub const MOST_INLINED_OPERATIONS: u64 = 30_000;

/// How often the voxel source stands in a shader. All forms compute the same values by the same arithmetic.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Form {
    /// Wherever the text asks for a voxel.
    Unrolled,
    /// In one sample: its point and the neighbours of a lit one are gone through in a loop.
    OneSample,
    /// In one fetch: the corners of the sample are gone through in a loop too.
    OneFetch,
}

impl Form {
    /// A module in this form.
    pub(super) fn of(self, template: Template) -> Template {
        match template {
            GRADIENT if self >= Self::OneSample => GRADIENT_LOOPED,
            FILTER_LINEAR if self >= Self::OneFetch => FILTER_LINEAR_LOOPED,
            other => other,
        }
    }
}
