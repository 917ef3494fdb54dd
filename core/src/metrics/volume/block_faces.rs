//! Whether errors jump where a codec's blocks meet: the grid that shows in a picture.

use super::metric::{Metric, Subject};
use super::slab::Slab;
use crate::codec::Block;
use crate::metrics::{Better, Figure};

/// Jumps of the error between neighbours, across faces of blocks and inside them.
pub(super) struct BlockFaces {
    block: Option<Block>,
    /// Axes along which the volume has both kinds of neighbours.
    axes: [bool; 3],
}

/// Sum of jumps and how many there are, inside blocks and across their faces.
pub(super) type Jumps = [(f64, u64); 2];

impl Metric for BlockFaces {
    const FIGURES: &'static [Figure] = &[Figure {
        name: "block_discontinuity",
        heading: "block discontinuity",
        axis: "jump of the error across block faces ÷ inside",
        unit: "1",
        better: Better::Near("1"),
        definition: "mean of abs(e(p) − e(q)) over neighbours p and q in different blocks of the codec ÷ that over \
                     neighbours in one block, along axes that have both; empty for codecs without blocks",
    }];
    type Sums = Jumps;
    type Outcome = Option<f64>;

    fn new(subject: &Subject<'_>) -> Self {
        let extent = subject.layout().extent.to_array();
        let edge = subject.block.map_or([0; 3], |block| block.0.to_array());
        Self { block: subject.block, axes: [0, 1, 2].map(|a| edge[a] > 1 && extent[a] > edge[a]) }
    }

    fn slab(&self, slab: &Slab<'_>) -> Jumps {
        let mut jumps = Jumps::default();
        let Some(block) = self.block else { return jumps };
        let edges = block.0.to_array().map(|n| n as usize);
        for axis in (0..3).filter(|axis| self.axes[*axis]) {
            for (position, first, second) in slab.neighbours(axis) {
                // Along x a run passes through many blocks; up to its next face it is of one kind.
                let (mut from, mut position) = (0, position);
                while from < first.len() {
                    let across = (position + 1).is_multiple_of(edges[axis]);
                    let alike = match (axis, across) {
                        (0, true) => 1,
                        (0, false) => edges[0] - 1 - position % edges[0],
                        _ => first.len(),
                    };
                    let to = if axis == 0 { (from + alike * slab.channels).min(first.len()) } else { alike };
                    let pairs = first[from..to].iter().zip(&second[from..to]);
                    let run: f64 = pairs.map(|(a, b)| (a - b).abs()).sum();
                    jumps[usize::from(across)].0 += run;
                    jumps[usize::from(across)].1 += (to - from) as u64;
                    (from, position) = (to, position + alike);
                }
            }
        }
        jumps
    }

    fn add(&self, sums: &mut Jumps, next: Jumps) {
        for (sum, next) in sums.iter_mut().zip(next) {
            sum.0 += next.0;
            sum.1 += next.1;
        }
    }

    fn finish(&self, _: &Subject<'_>, [inside, across]: Jumps) -> Option<f64> {
        if inside.1 == 0 || across.1 == 0 {
            return None;
        }
        let [inside, across] = [inside, across].map(|(sum, pairs)| sum / pairs as f64);
        // 0 ÷ 0 and the result of infinite errors are not numbers; a jump against none is infinite.
        Some(across / inside).filter(|ratio| !ratio.is_nan())
    }

    fn values(outcome: &Option<f64>) -> Vec<Option<f64>> {
        vec![*outcome]
    }
}

#[cfg(test)]
mod tests {
    use crate::metrics::volume::tests::error_of;

    fn of(extent: [u32; 3], errors: &[f32], block: Option<&str>) -> Option<f64> {
        error_of(extent, errors, block).value("block_discontinuity")
    }

    #[test]
    fn jumps_across_faces_are_divided_by_those_inside() {
        // Blocks of 2: inside jumps 1, 1 and 1, across 3 and 5.
        let row = [0.0, 1.0, 4.0, 5.0, 10.0, 11.0];
        assert_eq!(of([6, 1, 1], &row, Some("2")), Some(4.0));
        // The same along y and z, where it crosses a slab.
        assert_eq!(of([1, 6, 1], &row, Some("2")), Some(4.0));
        assert_eq!(of([1, 1, 6], &row, Some("2")), Some(4.0));
        // With blocks of 3 the faces lie elsewhere: inside 1, 3, 5, 1, across 1.
        assert_eq!(of([6, 1, 1], &row, Some("3")), Some(1.0 / 2.5));
        // A block cut at the edge: inside 1, 1; across 3, 5.
        assert_eq!(of([5, 1, 1], &row[..5], Some("2")), Some(4.0));
    }

    #[test]
    fn every_axis_counts_that_has_both_kinds() {
        let edges = [4usize, 2, 3];
        let block = |i: usize| [i % 8 / edges[0], i / 8 % 6 / edges[1], i / 48 / edges[2]];
        // Each block has a constant error of its own: nothing jumps inside.
        let errors: Vec<f32> = (0..8 * 6 * 9).map(|i| block(i).iter().sum::<usize>() as f32).collect();
        assert_eq!(of([8, 6, 9], &errors, Some("4x2x3")), Some(f64::INFINITY));
        // A ramp jumps alike everywhere.
        let ramp: Vec<f32> = (0..8 * 6 * 9).map(|i| (i % 8 + i / 8 % 6 + i / 48) as f32).collect();
        assert_eq!(of([8, 6, 9], &ramp, Some("4x2x3")), Some(1.0));
    }

    #[test]
    fn without_blocks_faces_or_errors_there_is_none() {
        let row = [0.0, 1.0, 4.0, 5.0, 10.0, 11.0];
        assert_eq!(of([6, 1, 1], &row, None), None);
        assert_eq!(of([6, 1, 1], &row, Some("8")), None);
        assert_eq!(of([6, 1, 1], &row, Some("1")), None);
        assert_eq!(of([6, 1, 1], &[0.0; 6], Some("2")), None);
        assert_eq!(of([6, 1, 1], &[f32::NAN; 6], Some("2")), None);
    }
}
