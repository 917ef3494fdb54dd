//! The payload `fixed`: every block has one code of each stage.

use cvr_codebook::pack::BitPacker;
use cvr_core::codec::{EncodeError, Progress};
use cvr_core::container::StreamWriter;
use cvr_core::kit::{BlockRow, Measured, code_frame};
use cvr_core::volume::{BrickSource, FrameIndex};

use super::beam::{About, Coder};
use super::to_sums;
use crate::stream::{BASE, Geometry, INDEX, TOP, block};

/// Appends the codes of a frame; returns the errors of its voxels.
pub fn encode_frame(
    source: &dyn BrickSource,
    g: &Geometry,
    frame: FrameIndex,
    coder: &Coder<'_>,
    out: &mut dyn StreamWriter,
    run: &Progress<'_>,
) -> Result<Measured, EncodeError> {
    let integers = source.layout().sample.is_integer();
    let mut packer = BitPacker::new(g.index_bits);
    let mut measured = Measured::NOTHING;
    let row = |by, bz| Ok(code_row(g, coder, &BlockRow::read(source, block(0), frame, by, bz)?, integers));
    code_frame(&g.grids[0], 1, run, row, |rows| {
        let mut words = Vec::new();
        for (codes, of_row) in rows {
            codes.into_iter().for_each(|code| packer.push(code, &mut words));
            measured = measured.and(of_row);
        }
        Ok(out.append_words(INDEX, &words)?)
    })?;
    let mut last = Vec::new();
    packer.flush(&mut last);
    out.append_words(INDEX, &last)?;
    Ok(measured)
}

/// The codes of a row of blocks, and the errors of its voxels. Blocks that the volume's border cuts are filled up: what lies
/// outside is part of the means at coarser resolutions.
fn code_row(g: &Geometry, coder: &Coder<'_>, row: &BlockRow, integers: bool) -> (Vec<u32>, Measured) {
    let (blocks, dimension) = (g.grids[0].blocks().x(), g.dimension() as usize);
    let mut samples = Vec::with_capacity(blocks as usize * dimension);
    (0..blocks).for_each(|bx| row.append(bx, &mut samples));
    let mut sums = samples.clone();
    to_sums(g.quantiser, BASE, &mut sums);
    let inside: Vec<Vec<bool>> =
        (0..blocks).map(|bx| cvr_codebook::blocks::inside(block(0), g.channels, row.cut(bx))).collect();
    let about = |bx: usize| {
        let inside = Some(&inside[bx][..]).filter(|inside| !inside.iter().all(|i| *i));
        About { inside, ..About::WHOLE }
    };
    let codes = coder.code(&sums, about);
    let mut measured = Measured::NOTHING;
    let of_blocks = samples.chunks_exact(dimension).zip(codes.chunks_exact(g.stages as usize));
    for (inside, (samples, codes)) in inside.iter().zip(of_blocks) {
        for (i, sample) in samples.iter().enumerate().filter(|(i, _)| inside[*i]) {
            let sum = coder.sum(codes, i) + BASE;
            measured.add(*sample, g.quantiser.value(sum.clamp(0, TOP) as u32), integers);
        }
    }
    (codes, measured)
}
