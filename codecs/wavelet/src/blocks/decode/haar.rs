//! Haar: the twin of haar.wgsl. A voxel needs one record of each level.

use super::group::ALL;
use super::{Group, Head, place, slot};
use crate::blocks::shape::levels;

/// One of the two samples of a pair.
#[inline]
const fn half(low: i32, high: i32, side: u32) -> i32 {
    let second = low.wrapping_sub(high >> 1);
    if side == 0 { second.wrapping_add(high) } else { second }
}

/// One sample of eight: `c[0]` is low-pass along all axes.
#[inline]
fn eighth(c: [i32; 8], side: [u32; 3]) -> i32 {
    let near = half(half(c[0], c[1], side[0]), half(c[2], c[3], side[0]), side[1]);
    let far = half(half(c[4], c[5], side[0]), half(c[6], c[7], side[0]), side[1]);
    half(near, far, side[2])
}

/// The integer at a position of a block.
#[inline]
fn walk(head: &Head<'_>, root: &Group, inside: [u32; 3]) -> i32 {
    let (mut value, levels) = (head.low, levels(head.frame.shape.edge()));
    for level in 0..levels {
        let p = inside.map(|v| v >> (levels - level));
        let side = inside.map(|v| v >> (levels - 1 - level) & 1);
        let (group, place) = place(level, p);
        let record = match group {
            0 => root.record(place),
            child => head.child(child as u32 - 1).record(place),
        };
        if record.is_empty() {
            // All differences are 0.
            continue;
        }
        let mut c = [value; 8];
        let high = head.coefficients(record, level, ALL);
        for (axes, c) in c.iter_mut().enumerate().skip(1) {
            *c = high[slot(axes)];
        }
        value = eighth(c, side);
    }
    value
}

/// The integer at a position.
#[inline]
pub fn one(head: &Head<'_>, inside: [u32; 3]) -> i32 {
    if head.coded { walk(head, &head.root(), inside) } else { head.low }
}

/// The integers at the corners of a cell, which reaches one further along the axes of `size`.
#[inline]
pub fn corners(head: &Head<'_>, inside: [u32; 3], size: [u32; 3]) -> [i32; 8] {
    if !head.coded {
        return [head.low; 8];
    }
    let root = head.root();
    std::array::from_fn(|i| walk(head, &root, [0, 1, 2].map(|a| inside[a] + ((i >> a) as u32 & size[a]))))
}
