//! The shader of the site *deferred*: every voxel of a frame, decoded once, as texels.

use cvr_shaders::DEFERRED_DECODE;

use super::{BindingKind, BindingLimits, GeneratedShader, Request, ShaderError, Source, generate};
use crate::codec::TexelFormat;
use crate::volume::VolumeLayout;

/// Generates the pass that decodes a slab of a frame through `source` and writes its texels, in rows of a multiple of
/// 256 bytes, into a buffer of words. Its invocations stand for groups of voxels along x ([`voxels_per_invocation`]),
/// rows along y and slices along z; 64 of them along x form a workgroup.
///
/// # Errors
/// As [`generate()`].
pub fn generate_decode(
    source: &Source<'_>,
    layout: &VolumeLayout,
    format: TexelFormat,
    limits: BindingLimits,
) -> Result<GeneratedShader, ShaderError> {
    generate(&Request {
        templates: &[DEFERRED_DECODE],
        entry: "decode",
        bindings: &[BindingKind::Slab, BindingKind::Texels(format)],
        layout,
        source: source.clone(),
        filter: None,
        limits,
    })
}

/// Voxels that one invocation of the decode pass writes: as many scalars as share a word, or one colour.
#[must_use]
pub const fn voxels_per_invocation(format: TexelFormat, channels: u32) -> u32 {
    if channels == 1 { (4 / format.bytes()) as u32 } else { 1 }
}
