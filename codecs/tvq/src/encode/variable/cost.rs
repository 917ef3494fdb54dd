//! Bits of everything except codes with the payload `variable`, and the target.

use cvr_groups::mean_width;

use crate::encode::closed_loop::Plane;
use crate::encode::domain::Domain;
use crate::encode::tuned::codebooks::FULL_BLOCKS;
use crate::encode::work::Work;
use crate::settings::{CODE_BITS, MEAN_BITS, Target};
use crate::stream::geometry::{GROUP, HEAD_WORDS, VOXELS, number, positions};
use cvr_groups::Aim;

/// Bits of header, tables, codebooks and heads of groups.
pub fn fixed_bits(work: &Work<'_>, books: u32, codewords: f64) -> f64 {
    let entries = codewords * VOXELS as f64 * f64::from(work.entry_bits());
    work.overhead(books) + entries + groups(work) * f64::from(32 * HEAD_WORDS)
}

/// Groups of all channels and frames.
pub fn groups(work: &Work<'_>) -> f64 {
    let of_domain = |d: &Domain| {
        let groups = d.size.map(|s| f64::from(s.div_ceil(GROUP))).iter().product::<f64>();
        groups * d.blocks() as f64 / d.plane_blocks() as f64
    };
    work.domains().map(of_domain).sum()
}

/// Bits of the means of one plane. Their codes are finer than the stored ones by `shift` bits.
pub fn mean_bits(plane: &Plane, size: [u32; 3], shift: u32) -> f64 {
    let groups = size.map(|s| s.div_ceil(GROUP));
    let of_group = |group: [u32; 3]| {
        let first = group.map(|b| b * GROUP);
        let cut = [0, 1, 2].map(|a| GROUP.min(size[a] - first[a]));
        let code = |p: [u32; 3]| {
            let mean = plane.means[number([0, 1, 2].map(|a| first[a] + p[a]), size)];
            (mean + (1 << shift >> 1)) >> shift
        };
        let (_, width) = mean_width(positions(cut).map(code));
        f64::from(width * cut.iter().product::<u32>())
    };
    positions(groups).map(of_group).sum()
}

/// The target of the payload `variable`. Errors are in data units.
pub fn aim(work: &Work<'_>) -> Aim {
    match work.options.target {
        Target::Rate(rate) => Aim::Bits(rate * work.samples()),
        Target::Psnr(psnr) | Target::Both { psnr, .. } => Aim::Error(work.error_of(psnr)),
        Target::Codes => {
            let [codes, means, books] = default_bits(work);
            Aim::Bits(codes + means + books + fixed_bits(work, 3, 0.0))
        }
    }
}

/// Without a target: bits of codes, of means and of codebooks. Blocks pay for codebooks: 256 codewords of each
/// partition if there are enough blocks, proportionally fewer if not. With tables and heads these are at most half of
/// the uncompressed volume.
pub fn default_bits(work: &Work<'_>) -> [f64; 3] {
    let (blocks, tables) = (work.blocks(), work.tables());
    let share = (blocks / tables / FULL_BLOCKS).min(1.0);
    let codewords = f64::from(CODE_BITS << 5) * share * tables;
    let books = codewords * VOXELS as f64 * f64::from(work.entry_bits());
    let bits = [f64::from(CODE_BITS) * blocks, f64::from(MEAN_BITS) * blocks, books];
    let raw = 8.0 * work.samples() * work.layout.sample.bytes() as f64;
    let beside = fixed_bits(work, 3, 0.0) - work.header_bits();
    let part = (0.5 * raw - beside) / bits.iter().sum::<f64>();
    bits.map(|bits| bits * part.clamp(0.0, 1.0))
}
