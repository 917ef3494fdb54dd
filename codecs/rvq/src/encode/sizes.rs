//! The size of codebooks where none is given.

use cvr_core::volume::VolumeLayout;

use super::{Entries, Options, block};

/// Bits of a codebook over bits of its codes, at most.
const SHARE: f64 = 0.25;
/// Sizes that are chosen, as powers of two.
const POWERS: std::ops::RangeInclusive<u32> = 4..=12;

/// The largest power of two, from 16 to 4096, at which a codebook takes at most a quarter of the bits of its codes: the paper
/// has 4096 for volumes of thousands of millions of blocks, where codebooks cost nothing.
#[must_use]
pub fn automatic(layout: &VolumeLayout, options: Options, entries: Entries) -> u32 {
    let frames = if options.training.per_frame { 1 } else { layout.frames };
    let blocks = block(0).grid(layout.extent).voxels() as f64 * f64::from(frames);
    let voxel_bits = if entries == Entries::Colours { 32 } else { entries.code_bits() * layout.channels };
    let pays = |bits: &u32| {
        let codebook = f64::from(64 * voxel_bits) * f64::from(1_u32 << bits);
        codebook <= SHARE * blocks * f64::from(*bits)
    };
    1 << POWERS.rev().find(pays).unwrap_or(*POWERS.start())
}
