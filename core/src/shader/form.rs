//! The number of copies of the voxel source in a shader.
//!
//! A software rasteriser compiles each call as a copy of the called function. A sample between voxels fetches eight
//! voxels. A lit sample takes seven such samples. A long codec (`zfp`) that is copied so often compiles for minutes. A
//! loop around one call is compiled once, but some devices end long loops by counting rounds, and a short codec runs
//! slower in a loop. So calls are written out while the text is short, and looped above a stated length.

use cvr_shaders::{FILTER_LINEAR, FILTER_LINEAR_LOOPED, GRADIENT, GRADIENT_LOOPED, Template};

/// The longest text without loops, in [`super::GeneratedShader::inlined_operations`]. llvmpipe compiles it within about
/// two seconds (docs/benchmarks/shader-compile.md).
pub const MOST_INLINED_OPERATIONS: u64 = 30_000;

/// Number of copies of the voxel source in a shader. All forms compute the same values with the same arithmetic.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Form {
    /// Wherever the text asks for a voxel.
    Unrolled,
    /// One copy of a sample. A loop goes over the point and the neighbours of a lit point.
    OneSample,
    /// One copy of a fetch. A second loop goes over the corners of the sample.
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
