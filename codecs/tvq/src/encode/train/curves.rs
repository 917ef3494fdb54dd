//! Training curves: the error that codebooks of growing sizes leave, in their training blocks and in others.

use cvr_core::codec::{Cancelled, Progress};

use super::trainer::{State, Trainer};
use crate::stream::geometry::VOXELS;
use crate::stream::table::Partition;

/// Natural logarithms of the fraction of the error that codebooks of one partition leave, behind certain earlier
/// codebooks.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The fraction that the earlier codebooks have left.
    pub before: f64,
    /// The fraction that is left of it, by width: in training blocks, and in others.
    pub left: Vec<[f64; 2]>,
}

/// Training curves.
#[derive(Clone, Debug)]
pub struct Curves {
    /// One for each partition.
    pub of: Vec<Curve>,
    /// Mean square after the means, in units of sums.
    pub mean_square: f64,
    /// Blocks that trained.
    pub trained: f64,
}

impl Curves {
    /// Training curves at some widths, smallest first. For each partition, the codebooks of earlier partitions have 7
    /// bits.
    ///
    /// # Errors
    /// When `run` was cancelled.
    pub fn measure(
        trainer: &Trainer<'_>,
        widths: &[u32],
        (mean_shift, threshold): (u32, f64),
        run: &Progress<'_>,
    ) -> Result<Self, Cancelled> {
        let classes = trainer.classes(threshold);
        let mut state = trainer.begin(mean_shift);
        let (train, test): (Vec<usize>, Vec<usize>) = (0..trainer.sample.len()).partition(|i| i % 3 != 2);
        let groups = if test.is_empty() { [train.clone(), train] } else { [train, test] };
        let totals =
            |state: &State| [0, 1].map(|g: usize| groups[g].iter().map(|i| state.errors[*i]).sum::<f64>());
        let parts = |now: [f64; 2], before: [f64; 2]| {
            [0, 1].map(|g| if before[g] > 0.0 { (now[g] / before[g]).max(1e-9).ln() } else { 0.0 })
        };
        let begun = totals(&state);
        let all: Vec<usize> = (0..trainer.sample.len()).collect();
        let mut of = Vec::new();
        for partition in Partition::ALL {
            let trains = |i: &usize| trainer.trains(classes[*i], partition);
            let members: Vec<usize> = groups[0].iter().copied().filter(trains).collect();
            let before = totals(&state);
            let [own, other] = parts(before, begun);
            let mut curve = Curve { before: 0.5 * (own + other), left: Vec::new() };
            let mut after = None;
            for width in widths {
                let mut next = state.clone();
                if !members.is_empty() {
                    let book = trainer.book(&state, &classes, (&members, partition), 1 << width, run)?;
                    Trainer::subtract(&mut next, &book, &all);
                }
                curve.left.push(parts(totals(&next), before));
                if *width <= 7 {
                    after = Some(next);
                }
            }
            of.push(curve);
            state = after.unwrap_or(state);
        }
        let mean_square = begun[1] / (groups[1].len() * VOXELS) as f64;
        Ok(Self { of, mean_square, trained: groups[0].len() as f64 })
    }
}
