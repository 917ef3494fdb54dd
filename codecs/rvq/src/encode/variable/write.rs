//! Groups and codebooks into a stream.

use cvr_core::codec::{EncodeError, EncodeReport};
use cvr_core::container::StreamWriter;
use cvr_core::kit::Measured;
use cvr_core::volume::FrameIndex;
use cvr_groups::{Codes, KeptPlane, Writer, mean_width};

use super::coding::Frame;
use super::{Coded, Work};
use crate::encode::RvqEncoder;
use crate::encode::stage::packed;
use crate::stream::{CODEBOOK, Geometry, HEADS, INDEX, Parameters, Payload, Table};

/// What is written.
pub struct Written {
    pub tables: Vec<Coded>,
    /// What each block keeps, by table and frame of it.
    pub kept: Vec<Vec<KeptPlane>>,
    /// Bits of a code that blocks were planned with.
    pub width: u32,
}

/// Groups of a frame: heads and words. `None` where they exceed 2^32 words.
fn groups(g: &Geometry, coded: &Frame, kept: &KeptPlane) -> Option<(Vec<u32>, Vec<u32>)> {
    let mut writer = Writer::new(g.parts());
    let blocks = g.grids[0].blocks();
    for n in 0..g.groups.voxels() as usize {
        let (first, size) = g.group(g.groups.position(n));
        let of_group: Vec<Codes<'_>> = (0..size.iter().product())
            .map(|i: u32| {
                let p = [i % size[0], i / size[0] % size[1], i / (size[0] * size[1])];
                let [x, y, z] = [0, 1, 2].map(|a| (first[a] + p[a]) as usize);
                let block = (z * blocks.y() as usize + y) * blocks.x() as usize + x;
                let codes = coded.codes(block, kept.codes[block].into());
                Codes { mean: coded.mean(block), codes, escape: kept.escape(block) }
            })
            .collect();
        writer.push(&of_group, mean_width(of_group.iter().map(|b| b.mean)), g.index_bits)?;
    }
    Some(writer.finish())
}

/// Writes everything; the report has the largest error of a sample.
///
/// # Errors
/// Those of reading and writing, when the run was cancelled, and where a frame has more than 2^32 words.
pub fn write(
    encoder: &RvqEncoder,
    work: &Work<'_>,
    Written { tables, mut kept, width }: Written,
    out: &mut dyn StreamWriter,
) -> Result<EncodeReport, EncodeError> {
    let of_table = |coded: &Coded| Table {
        codewords: coded.stages.iter().map(|s| s.codebook.size() as u32).collect(),
        scales: coded.stages.iter().map(|s| s.scale.byte() as u8).collect(),
        mean_shift: coded.means.shift,
    };
    let mut parameters = Parameters {
        payload: Payload::Variable,
        grid: work.grid.blocks().to_array(),
        offset: work.quantiser.offset(),
        step: work.quantiser.step(),
        entries: work.entries,
        tables: tables.iter().map(of_table).collect(),
        frame_words: vec![0; work.layout.frames as usize],
        training: encoder
            .record(tables.iter().map(|t| t.blocks).collect(), tables.iter().map(|t| t.rounds).collect()),
    };
    let geometry = Geometry::of_stream(&work.layout, &parameters).map_err(EncodeError::Unsupported)?;
    let (mut measured, mut frame) = (Measured::NOTHING, 0);
    for (coded, kept) in tables.iter().zip(&mut kept) {
        out.append_words(CODEBOOK, &packed(&coded.stages, &geometry))?;
        let coding = work.coding(&coded.stages, coded.means, width, 1.0);
        for (of_frame, kept) in coded.frames.iter().zip(kept) {
            let index = FrameIndex(frame as u32);
            let of = coding.finish((work.source, &work.grid), index, (of_frame, kept), work.run)?;
            measured = measured.and(of);
            let (heads, words) = groups(&geometry, of_frame, kept).ok_or_else(|| {
                EncodeError::Unsupported("a frame takes more than 2^32 words; ask for less".to_owned())
            })?;
            out.append_words(HEADS, &heads)?;
            out.append_words(INDEX, &words)?;
            parameters.frame_words[frame] = words.len() as u64;
            frame += 1;
        }
    }
    out.shape(CODEBOOK, &geometry.codebook_shape())?;
    out.shape(HEADS, &geometry.heads_shape())?;
    out.shape(INDEX, &[parameters.frame_words.iter().sum()])?;
    out.parameters_of(&parameters)?;
    Ok(EncodeReport { error_bound: Some(measured.error), notes: Vec::new() })
}
