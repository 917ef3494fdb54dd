//! Decodes voxels, cells and boxes from the bits of their blocks. The twin of decode.wgsl. This code defines the codec.

pub mod five_three;
pub mod group;
pub mod haar;

use cvr_core::kit::{FetchVoxels, Voxel, fill_from_blocks};
use cvr_core::render::Cell;
use cvr_core::volume::Region;

use self::group::{ALL, Group, Record};
use super::lift::inverse;
use super::shape::{CHILD_PLACES, KIND, ROOT_PLACES, SLOT, Shape, for_places, levels, place_of};
use super::write::CHILD_BITS;
use super::{Filter, shape};
use cvr_core::kit::number as take;

/// The bit of a table's entry that says that the rest is a low-pass coefficient.
pub const CONSTANT: u32 = 0x8000_0000;

/// One frame of a stream.
#[derive(Copy, Clone, Debug)]
pub struct Frame<'a> {
    /// An entry for each block of each channel.
    pub(super) table: &'a [u32],
    /// Bits of all blocks.
    pub(super) words: &'a [u32],
    /// Sizes and steps.
    pub(super) shape: &'a Shape,
}

/// A block: its low-pass coefficient, and where its other bits are.
#[derive(Copy, Clone, Debug)]
pub struct Head<'a> {
    frame: Frame<'a>,
    /// Times its step.
    low: i32,
    /// Whether there are other bits. Without, the block is constant.
    coded: bool,
    /// The block begins at a bit of a word.
    first: usize,
    start: u32,
    /// Bit of the places of the children. 0 if all are empty.
    children: u32,
    /// Bit of the root.
    root: u32,
}

impl<'a> Head<'a> {
    /// The head that an entry of the table names. `None` if its bits lie outside.
    pub(super) fn checked(frame: Frame<'a>, entry: u32) -> Option<Self> {
        let Shape { low_bits, .. } = *frame.shape;
        let deep = levels(frame.shape.edge()) > 3;
        let needed = (u64::from(entry & 3) * 8) + u64::from(low_bits) + u64::from(deep);
        let there = 32 * (frame.words.len() as u64).saturating_sub(u64::from(entry >> 2));
        (entry & CONSTANT != 0 || needed <= there).then(|| Self::of(frame, entry))
    }

    #[inline]
    fn of(frame: Frame<'a>, entry: u32) -> Self {
        let Shape { low_bits, low_base, low_step, .. } = *frame.shape;
        if entry & CONSTANT != 0 {
            let low = ((entry << 1) as i32 >> 1).wrapping_mul(low_step);
            return Self { frame, low, coded: false, first: 0, start: 0, children: 0, root: 0 };
        }
        let (first, start) = ((entry >> 2) as usize, (entry & 3) * 8);
        let low = low_base.wrapping_add(take(frame.words, first, start, low_bits) as i32);
        let (mut root, mut children) = (start + low_bits, 0);
        if levels(frame.shape.edge()) > 3 {
            let flag = take(frame.words, first, root, 1);
            root += 1;
            if flag == 1 {
                children = root;
                root += 8 * CHILD_BITS;
            }
        }
        Self { frame, low: low.wrapping_mul(low_step), coded: true, first, start, children, root }
    }

    /// The words and the bit at which the root begins.
    pub(super) const fn root_at(&self) -> Option<(usize, u32)> {
        if self.coded { Some((self.first, self.root)) } else { None }
    }

    /// Word and bit at which a child begins. `None` if it is empty. The places of the children must lie inside.
    pub(super) fn child_at(&self, child: u32) -> Option<(usize, u32)> {
        if self.children == 0 {
            return None;
        }
        let place = take(self.frame.words, self.first, self.children + CHILD_BITS * child, CHILD_BITS);
        (place != 0).then_some((self.first, self.start + 8 * place))
    }

    #[inline]
    fn root(&self) -> Group {
        Group::read(self.frame.words, self.first, self.root, ROOT_PLACES as u32)
    }

    #[inline]
    fn child(&self, child: u32) -> Group {
        self.child_at(child).map_or(Group::EMPTY, |(first, bit)| {
            Group::read(self.frame.words, first, bit, CHILD_PLACES as u32)
        })
    }

    /// The coefficients of a record by slot, times their steps. Only those of the slots in `wanted` are read.
    #[inline]
    fn coefficients(&self, record: Record, level: usize, wanted: u32) -> [i32; 7] {
        let mut out = record.coefficients(self.frame.words, self.first, wanted);
        for (q, kind) in out.iter_mut().zip(KIND) {
            *q = q.wrapping_mul(self.frame.shape.steps[level][kind]);
        }
        out
    }

    /// The integer at a position.
    #[inline]
    fn one(&self, inside: [u32; 3]) -> i32 {
        match self.frame.shape.filter {
            Filter::Haar => haar::one(self, inside),
            Filter::FiveThree => five_three::one(self, inside),
        }
    }

    /// The integers at the corners of a cell, which reaches one further along the axes of `size`.
    #[inline]
    fn corners(&self, inside: [u32; 3], size: [u32; 3]) -> [i32; 8] {
        match self.frame.shape.filter {
            Filter::Haar => haar::corners(self, inside, size),
            Filter::FiveThree => five_three::corners(self, inside, size),
        }
    }

    /// The values of all voxels, x fastest.
    fn values(&self) -> Vec<f32> {
        let edge = self.frame.shape.edge();
        let mut block = vec![0_i32; edge * edge * edge];
        if self.coded {
            block[0] = self.low;
            let mut groups = vec![self.root()];
            if edge > 8 {
                groups.extend((0..8).map(|child| self.child(child)));
            }
            for_places(edge, |number, level, at| {
                let (group, place) = shape::split(number);
                let record = groups[group].record(place as u32);
                if !record.is_empty() {
                    let all = self.coefficients(record, level, ALL);
                    at.into_iter().zip(all).for_each(|(at, coefficient)| block[at] = coefficient);
                }
            });
            inverse(self.frame.shape.filter, edge, &mut block);
        } else {
            block.fill(self.low);
        }
        block.into_iter().map(|x| self.frame.shape.scale.value(x)).collect()
    }
}

impl<'a> Frame<'a> {
    #[inline]
    fn head(&self, block: [u32; 3], channel: u32) -> Head<'a> {
        let blocks = self.shape.grid.blocks().voxels() as usize;
        Head::of(*self, self.table[channel as usize * blocks + self.shape.grid.number(block)])
    }

    #[inline]
    fn split(&self, p: [u32; 3]) -> ([u32; 3], [u32; 3]) {
        let edge = self.shape.edge() as u32;
        (p.map(|v| v / edge), p.map(|v| v % edge))
    }
}

impl FetchVoxels for Frame<'_> {
    fn channels(&self) -> usize {
        self.shape.channels as usize
    }

    #[inline]
    fn fetch(&self, p: [u32; 3]) -> Voxel {
        let (block, inside) = self.split(p);
        let mut out = [0.0; 4];
        for (c, out) in (0..self.shape.channels).zip(&mut out) {
            *out = self.shape.scale.value(self.head(block, c).one(inside));
        }
        out
    }

    /// A cell inside a block finds what its corners share once.
    #[inline]
    fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> Cell {
        let (block, inside) = self.split(p);
        if block != self.split(q).0 {
            return std::array::from_fn(|i| {
                self.fetch([0, 1, 2].map(|a| if i >> a & 1 == 0 { p[a] } else { q[a] }))
            });
        }
        let mut out = [[0.0; 4]; 8];
        for c in 0..self.shape.channels {
            let corners = self.head(block, c).corners(inside, [0, 1, 2].map(|a| q[a] - p[a]));
            for (out, corner) in out.iter_mut().zip(corners) {
                out[c as usize] = self.shape.scale.value(corner);
            }
        }
        out
    }

    /// Decodes each block once.
    fn fetch_box(&self, region: Region, out: &mut [f32]) {
        let values = |block, c| self.head(block, c as u32).values();
        fill_from_blocks(&self.shape.grid, region, self.channels(), out, values);
    }
}

/// Group and place of position `p` of a level.
#[inline]
fn place(level: usize, p: [u32; 3]) -> (usize, u32) {
    let (group, place) = place_of(level, p.map(|v| v as usize));
    (group, place as u32)
}

/// Slot of the coefficient that is high-pass along the axes of these bits.
#[inline]
const fn slot(axes: usize) -> usize {
    SLOT[axes]
}
