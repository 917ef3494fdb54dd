//! Rows of blocks: read, transformed and quantised, and how far the decoded samples are off.

use cvr_core::codec::{EncodeError, Progress};
use cvr_core::kit::{BlockRow, Measured};
use cvr_core::volume::{BrickSource, FrameIndex};
use rayon::prelude::*;

use super::lift::{forward, inverse};
use super::quantise::Quantiser;
use super::shape::{Coefficients, grid};

/// Room for one block, used again and again.
#[derive(Debug, Default)]
pub struct Scratch {
    vector: Vec<f32>,
    block: Vec<i32>,
    coefficients: Coefficients,
}

/// Errors of decoded samples.
#[derive(Copy, Clone, Debug)]
pub struct Errors {
    /// Sum of squares.
    pub squares: f64,
    /// Range and largest error.
    pub measured: Measured,
}

impl Errors {
    /// No samples.
    pub const NONE: Self = Self { squares: 0.0, measured: Measured::NOTHING };

    /// Both together.
    pub const fn and(self, other: Self) -> Self {
        Self { squares: self.squares + other.squares, measured: self.measured.and(other.measured) }
    }
}

/// Reads a row of blocks along x and hands the coefficients of each block of each channel to `each`: by block, then by
/// channel. Returns the errors if `measures`.
pub fn row(
    source: &dyn BrickSource,
    quantiser: &Quantiser,
    (frame, by, bz): (FrameIndex, u32, u32),
    measures: bool,
    mut each: impl FnMut(&Coefficients),
) -> Result<Errors, EncodeError> {
    let (layout, edge) = (source.layout(), quantiser.edge);
    let grid = grid(layout, edge as u32);
    let row = BlockRow::read(source, grid.block(), frame, by, bz)?;
    let channels = layout.channels as usize;
    let [width, height, depth] = grid.blocks().to_array();
    let rows = frame.0.wrapping_mul(depth).wrapping_add(bz).wrapping_mul(height).wrapping_add(by);
    let first = rows.wrapping_mul(width);
    let (integers, mut errors) = (layout.sample.is_integer(), Errors::NONE);
    let Scratch { mut vector, mut block, mut coefficients } = Scratch::default();
    for bx in 0..grid.blocks().x() {
        vector.clear();
        row.append(bx, &mut vector);
        let cut = row.cut(bx);
        for c in 0..channels {
            block.clear();
            block.extend(vector.iter().skip(c).step_by(channels).map(|v| quantiser.scale.integer(*v)));
            forward(quantiser.filter, edge, &mut block);
            quantiser.quantise(&block, first.wrapping_add(bx), &mut coefficients);
            each(&coefficients);
            if !measures {
                continue;
            }
            quantiser.restore(&coefficients, &mut block);
            inverse(quantiser.filter, edge, &mut block);
            for z in 0..cut[2] {
                for y in 0..cut[1] {
                    let from = (z * edge + y) * edge;
                    for i in from..from + cut[0] {
                        let (sample, decoded) = (vector[i * channels + c], quantiser.scale.value(block[i]));
                        errors.squares += (f64::from(decoded) - f64::from(sample)).powi(2);
                        errors.measured.add(sample, decoded, integers);
                    }
                }
            }
        }
    }
    Ok(errors)
}

/// Applies `of_row` to all rows of all frames, in parallel, and adds the results up in order.
pub fn over_rows<R: Send>(
    source: &dyn BrickSource,
    edge: u32,
    run: &Progress<'_>,
    of_row: impl Fn(FrameIndex, u32, u32) -> Result<R, EncodeError> + Sync,
    mut add: impl FnMut(R),
) -> Result<(), EncodeError> {
    let layout = source.layout();
    let [_, rows, layers] = grid(layout, edge).blocks().to_array();
    for frame in (0..layout.frames).map(FrameIndex) {
        for bz in 0..layers {
            let row = (0..rows).into_par_iter().map(|by| of_row(frame, by, bz));
            row.collect::<Result<Vec<R>, EncodeError>>()?.into_iter().for_each(&mut add);
            // Nothing is written yet.
            run.advance(0)?;
        }
    }
    Ok(())
}
