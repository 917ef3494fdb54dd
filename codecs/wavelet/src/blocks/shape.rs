//! Where coefficients stand: levels, places and slots; and the parameters of a stream.

use cvr_core::codec::Block;
use cvr_core::kit::BlockGrid;
use cvr_core::volume::{Extent, VolumeLayout};
use serde::{Deserialize, Serialize};

use super::Filter;
use super::scale::Scale;

/// Places of the first group of a block: of its levels of 1, 2³ and 4³ places.
pub const ROOT_PLACES: usize = 73;
/// Places of a group of the fourth level, which is cut into eight.
pub const CHILD_PLACES: usize = 64;
/// Most bits of a width.
pub const WIDEST: u32 = 31;

/// Slot of the coefficient that is high-pass along the axes of these bits (x, y, z; 1 to 7). The three of one axis come
/// first, then those of two axes, then that of all three.
pub const SLOT: [usize; 8] = [0, 0, 1, 3, 2, 4, 5, 6];
/// The inverse of [`SLOT`].
pub const AXES: [usize; 7] = [1, 2, 4, 3, 5, 6, 7];
/// Kind of a slot: how many axes are high-pass, less one.
pub const KIND: [usize; 7] = [0, 0, 0, 1, 1, 1, 2];

/// Number of levels of a block.
pub const fn levels(edge: usize) -> usize {
    edge.ilog2() as usize
}

/// Group and place of position `p` of a level, which has `2^level` places along each axis. Group 0 is the root, 1 to 8
/// are its children.
#[inline]
pub const fn place_of(level: usize, p: [usize; 3]) -> (usize, usize) {
    match level {
        0 => (0, 0),
        1 => (0, 1 + p[0] + 2 * p[1] + 4 * p[2]),
        2 => (0, 9 + p[0] + 4 * p[1] + 16 * p[2]),
        _ => (
            1 + (p[0] >> 2) + 2 * (p[1] >> 2) + 4 * (p[2] >> 2),
            (p[0] & 3) + 4 * (p[1] & 3) + 16 * (p[2] & 3),
        ),
    }
}

/// Group and place of a place's number among all of a block.
#[inline]
pub const fn split(number: usize) -> (usize, usize) {
    match number.checked_sub(ROOT_PLACES) {
        None => (0, number),
        Some(rest) => (1 + rest / CHILD_PLACES, rest % CHILD_PLACES),
    }
}

/// Quantised coefficients of a block of one channel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Coefficients {
    /// The one low-pass coefficient.
    pub low: i32,
    /// High-pass coefficients, by place and slot: the root's places, then those of each child.
    pub high: Vec<[i32; 7]>,
}

impl Coefficients {
    /// Number of places of a block.
    pub const fn places(edge: usize) -> usize {
        (edge * edge * edge - 1) / 7
    }

    /// The places of the root and of each child.
    pub fn groups(&self) -> impl Iterator<Item = &[[i32; 7]]> {
        let (root, children) = self.high.split_at(ROOT_PLACES);
        std::iter::once(root).chain(children.chunks_exact(CHILD_PLACES))
    }
}

/// Calls `each` for every place of a block: its number among all, its level, and the index of its coefficients in the
/// transformed block for slots 0 to 6.
#[inline]
pub fn for_places(edge: usize, mut each: impl FnMut(usize, usize, [usize; 7])) {
    for level in 0..levels(edge) {
        let m = 1 << level;
        for z in 0..m {
            for y in 0..m {
                for x in 0..m {
                    let (group, place) = place_of(level, [x, y, z]);
                    let number = match group {
                        0 => place,
                        child => ROOT_PLACES + (child - 1) * CHILD_PLACES + place,
                    };
                    let at = AXES.map(|axes| {
                        let [x, y, z] = [x + (axes & 1) * m, y + (axes >> 1 & 1) * m, z + (axes >> 2) * m];
                        (z * edge + y) * edge + x
                    });
                    each(number, level, at);
                }
            }
        }
    }
}

/// Words that tell these parameters from those of the other mode.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// Blocks on their own.
    #[serde(rename = "blocks")]
    Blocks,
}

/// The decode parameters in the container.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// `"blocks"`.
    pub mode: Mode,
    /// Voxels along each axis of a block: 8 or 16.
    pub block: u32,
    /// Filters of the transform.
    pub filter: Filter,
    /// How integers of the transform become values.
    pub scale: Scale,
    /// Step of the low-pass coefficient.
    pub low_step: i32,
    /// Steps of each level, the coarsest first: of coefficients that are high-pass along one, two and three axes.
    pub steps: Vec<[i32; 3]>,
    /// The low-pass coefficients of blocks count from here.
    pub low_base: i32,
    /// Bits of a low-pass coefficient.
    pub low_bits: u32,
    /// Words of the bits of each frame.
    pub frame_words: Vec<u64>,
}

/// Sizes and steps that are the same for all blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Blocks over the volume, edge blocks filled up.
    pub grid: BlockGrid,
    /// Values per voxel: 1 or 3. Each channel is coded on its own.
    pub channels: u32,
    /// Filters of the transform.
    pub filter: Filter,
    /// How integers of the transform become values.
    pub scale: Scale,
    /// Step of the low-pass coefficient.
    pub low_step: i32,
    /// Steps of each level and kind. Unused levels have steps of 1.
    pub steps: [[i32; 3]; 4],
    /// The low-pass coefficients of blocks count from here.
    pub low_base: i32,
    /// Bits of a low-pass coefficient.
    pub low_bits: u32,
}

impl Shape {
    /// The shape. `None` if the parameters are out of range or contradict the layout.
    pub fn new(layout: &VolumeLayout, p: &Parameters) -> Option<Self> {
        let edge = usize::try_from(p.block).ok().filter(|edge| matches!(edge, 8 | 16))?;
        let fits = p.steps.len() == levels(edge)
            && p.low_step > 0
            && p.steps.iter().flatten().all(|step| *step > 0)
            && p.low_bits <= WIDEST
            && p.frame_words.len() == layout.frames as usize
            && p.scale.is_sound();
        let mut steps = [[1; 3]; 4];
        steps[..levels(edge)].copy_from_slice(p.steps.get(..levels(edge))?);
        fits.then(|| Self {
            grid: grid(layout, p.block),
            channels: layout.channels,
            filter: p.filter,
            scale: p.scale,
            low_step: p.low_step,
            steps,
            low_base: p.low_base,
            low_bits: p.low_bits,
        })
    }

    /// Voxels along each axis of a block.
    #[inline]
    pub const fn edge(&self) -> usize {
        self.grid.block().0.x() as usize
    }

    /// Entries of a frame's table.
    pub const fn entries(&self) -> u64 {
        self.grid.blocks().voxels() * self.channels as u64
    }
}

/// The grid of blocks over a volume.
pub fn grid(layout: &VolumeLayout, edge: u32) -> BlockGrid {
    BlockGrid::new(Block(Extent::cube(edge).unwrap_or(Extent::ONE)), layout.extent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_coefficient_has_one_place_and_slot() {
        for edge in [8_usize, 16] {
            let mut seen = vec![0; edge.pow(3)];
            let mut places = vec![0; Coefficients::places(edge)];
            for_places(edge, |number, level, at| {
                places[number] += 1;
                assert_eq!(split(number).0 > 0, level == 3);
                at.iter().for_each(|i| seen[*i] += 1);
            });
            assert!(places.iter().all(|count| *count == 1), "{edge}");
            assert!(seen[0] == 0 && seen[1..].iter().all(|count| *count == 1), "{edge}");
        }
        (0..7).for_each(|slot| assert_eq!(SLOT[AXES[slot]], slot));
        (0..7).for_each(|slot| assert_eq!(KIND[slot] + 1, AXES[slot].count_ones() as usize));
    }
}
