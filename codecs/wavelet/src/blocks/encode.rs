//! The encoder: the range, the step, the sizes, and then the bits of all blocks, row by row.

use cvr_core::codec::{EncodeError, EncodeReport, Progress};
use cvr_core::container::{Element, StreamWriter};
use cvr_core::kit::{code_frame, value_range};
use cvr_core::memory;
use cvr_core::volume::{BrickSource, FrameIndex};

use super::decode::CONSTANT;
use super::quantise::Quantiser;
use super::rows::{Errors, row};
use super::shape::{Mode, Parameters, grid};
use super::target::Search;
use super::write::Coded;
use super::{BITS, Options, TABLE, Target};

/// Encodes a volume in blocks.
///
/// # Errors
/// If the target cannot be met, reading or writing fails, or `run` was cancelled.
pub fn encode(
    options: &Options,
    source: &dyn BrickSource,
    out: &mut dyn StreamWriter,
    run: &Progress<'_>,
) -> Result<EncodeReport, EncodeError> {
    let layout = source.layout();
    if !matches!(options.block, 8 | 16) {
        return Err(EncodeError::Unsupported(format!("blocks of {}: use 8 or 16", options.block)));
    }
    let grid = grid(layout, options.block);
    let range = value_range(source, grid.block(), run)?;
    let search = Search { source, options, range, run };
    let quantiser = search.settle()?;
    let low = search.sizes(&quantiser)?.low();
    let (blocks, channels) = (grid.blocks().voxels(), u64::from(layout.channels));
    let (mut errors, mut frame_words) = (Errors::NONE, Vec::new());
    for frame in (0..layout.frames).map(FrameIndex) {
        let what = || format!("the table of {blocks} blocks");
        let mut table = memory::zeroed::<u32>(blocks * channels, what)?;
        let held = memory::Held::of(&table);
        // Bytes of the frame so far. The last few wait until they fill a word.
        let (mut bytes, mut waiting, mut first) = (0_u64, Vec::new(), 0);
        let of_row = |by, bz| Row::of(source, &quantiser, (frame, by, bz), low);
        code_frame(&grid, 1, run, of_row, |rows| {
            for row in rows {
                for (i, piece) in row.pieces.iter().enumerate() {
                    let (bx, c) = (i / channels as usize, i % channels as usize);
                    table[c * blocks as usize + first + bx] = match *piece {
                        Piece::Constant(low) => CONSTANT | (low as u32 & !CONSTANT),
                        Piece::At(place) => place_in_frame(bytes + place as u64)?,
                    };
                }
                first += grid.blocks().x() as usize;
                bytes += row.bytes.len() as u64;
                errors = errors.and(row.errors);
                waiting.extend(row.bytes);
            }
            let rest = waiting.split_off(waiting.len() / 4 * 4);
            let whole = std::mem::replace(&mut waiting, rest);
            append_bits(out, &whole)
        })?;
        waiting.resize(waiting.len().next_multiple_of(4), 0);
        append_bits(out, &waiting)?;
        out.append_words(TABLE, &table)?;
        drop(held);
        frame_words.push(bytes.div_ceil(4));
    }
    let error = errors.measured.error;
    match options.target {
        Target::MaxError(most) if error > most => {
            return Err(EncodeError::Failed(format!(
                "an error of {error} remains where {most} was promised"
            )));
        }
        _ => {}
    }
    out.shape(TABLE, &[u64::from(layout.frames), channels, blocks])?;
    out.parameters_of(&Parameters {
        mode: Mode::Blocks,
        block: options.block,
        filter: options.filter,
        scale: quantiser.scale,
        low_step: quantiser.low_step,
        steps: quantiser.steps,
        low_base: low.0,
        low_bits: low.1,
        frame_words,
    })?;
    Ok(EncodeReport { error_bound: Some(error), notes: Vec::new() })
}

/// Appends bits. A stream of constant blocks has no tensor for them.
fn append_bits(out: &mut dyn StreamWriter, bytes: &[u8]) -> Result<(), EncodeError> {
    if !bytes.is_empty() {
        out.append(BITS, Element::U32, bytes)?;
    }
    Ok(())
}

/// The entry of a block that begins at this byte of its frame.
fn place_in_frame(byte: u64) -> Result<u32, EncodeError> {
    u32::try_from(byte).ok().filter(|place| place & CONSTANT == 0).ok_or_else(|| {
        let problem = "the blocks of a frame take more than 2 GiB: ask for fewer bits, or set block = 0, which \
                       codes whole volumes";
        EncodeError::Unsupported(problem.to_owned())
    })
}

/// A block: its low-pass coefficient if it is constant, else its first byte.
enum Piece {
    Constant(i32),
    At(usize),
}

/// The bits of a row of blocks: by block, then by channel.
struct Row {
    pieces: Vec<Piece>,
    bytes: Vec<u8>,
    errors: Errors,
}

impl Row {
    fn of(
        source: &dyn BrickSource,
        quantiser: &Quantiser,
        at: (FrameIndex, u32, u32),
        low: (i32, u32),
    ) -> Result<Self, EncodeError> {
        let (mut pieces, mut bytes, mut fits) = (Vec::new(), Vec::new(), true);
        let errors = row(source, quantiser, at, true, |coefficients| {
            let coded = Coded::of(coefficients);
            if coded.size().is_none() {
                return pieces.push(Piece::Constant(coded.low()));
            }
            pieces.push(Piece::At(bytes.len()));
            match coded.bytes(coefficients, low) {
                Some(block) => bytes.extend(block),
                None => fits = false,
            }
        })?;
        if !fits {
            let problem = "a block takes more than 64 KiB: use blocks of 8";
            return Err(EncodeError::Unsupported(problem.to_owned()));
        }
        Ok(Self { pieces, bytes, errors })
    }
}
