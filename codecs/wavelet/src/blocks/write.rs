//! A block's bits.

use super::bits::Bits;
use super::classes::{Classes, FORMAT_BITS, Format};
use super::shape::Coefficients;

/// Bits of the code of a group's planes.
pub const CODE_BITS: u32 = 3;
/// Bits of the place of a child, in bytes from the block's first.
pub const CHILD_BITS: u32 = 16;

/// Size of a coded block.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Size {
    /// Bits of the head and the root, without the low-pass coefficient.
    pub root: u32,
    /// Bytes of the children.
    pub children: u32,
}

/// A block, ready to be written. A block whose high-pass coefficients are all 0 has no bits.
#[derive(Clone, Debug)]
pub struct Coded {
    low: i32,
    /// Classes of the root and of the children.
    groups: Vec<Classes>,
}

impl Coded {
    /// The coded form of a block.
    pub fn of(coefficients: &Coefficients) -> Self {
        let constant = coefficients.high.iter().all(|place| *place == [0; 7]);
        let groups = if constant { Vec::new() } else { coefficients.groups().map(Classes::of).collect() };
        Self { low: coefficients.low, groups }
    }

    /// The low-pass coefficient.
    pub const fn low(&self) -> i32 {
        self.low
    }

    /// Size of its bits. `None` if the block is constant.
    pub fn size(&self) -> Option<Size> {
        let (root, children) = self.groups.split_first()?;
        let told = |child: &Classes| if is_empty(child) { 0 } else { (CODE_BITS + child.bits).div_ceil(8) };
        let all: u32 = children.iter().map(told).sum();
        // Blocks of 8³ have no children, and no flag for them.
        let flag = u32::from(!children.is_empty());
        let places = if all > 0 { CHILD_BITS * 8 } else { 0 };
        Some(Size { root: flag + places + CODE_BITS + root.bits, children: all })
    }

    /// Its bytes, for low-pass coefficients of `low_bits` bits from `low_base` on. `None` if the children lie too far
    /// apart for their places.
    pub fn bytes(&self, coefficients: &Coefficients, (low_base, low_bits): (i32, u32)) -> Option<Vec<u8>> {
        let mut bits = Bits::default();
        bits.push(self.low.wrapping_sub(low_base) as u32, low_bits);
        let mut groups = self.groups.iter().zip(coefficients.groups());
        let (root, root_places) = groups.next()?;
        let is_parent = self.groups[1..].iter().any(|child| !is_empty(child));
        let mut head = None;
        if self.groups.len() > 1 {
            bits.push(u32::from(is_parent), 1);
        }
        if is_parent {
            head = Some(low_bits + 1);
            (0..8).for_each(|_| bits.push(0, CHILD_BITS));
        }
        push(&mut bits, root, root_places);
        let mut starts = Vec::new();
        for (child, places) in groups {
            bits.align();
            starts.push(if is_empty(child) { 0 } else { u16::try_from(bits.len()).ok()? });
            if !is_empty(child) {
                push(&mut bits, child, places);
            }
        }
        let mut bytes = bits.finish();
        for (i, start) in starts.iter().enumerate() {
            head.iter().for_each(|head| set(&mut bytes, head + CHILD_BITS * i as u32, *start));
        }
        Some(bytes)
    }
}

fn is_empty(group: &Classes) -> bool {
    group.planes == 0 && group.bare
}

/// Adds a number of 16 bits to bits that are 0.
fn set(bytes: &mut [u8], bit: u32, number: u16) {
    let (byte, shift) = ((bit / 8) as usize, bit % 8);
    let shifted = u32::from(number) << shift;
    for (i, part) in shifted.to_le_bytes().into_iter().take(3).enumerate().filter(|(_, part)| *part != 0) {
        bytes[byte + i] |= part;
    }
}

/// Code, formats, planes and records of a group.
fn push(bits: &mut Bits, group: &Classes, places: &[[i32; 7]]) {
    bits.push(group.planes | u32::from(group.bare) << 2, CODE_BITS);
    let formats = &group.formats[usize::from(group.bare)..1 << group.planes];
    formats.iter().for_each(|format| bits.push(format.code(), FORMAT_BITS));
    for plane in 0..group.planes {
        group.classes.iter().for_each(|class| bits.push(u32::from(*class) >> plane & 1, 1));
    }
    for (class, place) in group.classes.iter().zip(places) {
        push_record(bits, group.formats[usize::from(*class)], place);
    }
}

fn push_record(bits: &mut Bits, format: Format, place: &[i32; 7]) {
    match format {
        Format::Empty => {}
        Format::Dense(widths) => {
            for (q, kind) in place.iter().zip(super::shape::KIND) {
                bits.push(*q as u32 & ((1 << widths[kind]) - 1), widths[kind]);
            }
        }
        Format::Sparse(count, width) => {
            place.iter().for_each(|q| bits.push(u32::from(*q != 0), 1));
            let mut left = count;
            for q in place.iter().filter(|q| **q != 0) {
                bits.push(u32::from(*q < 0) | (q.unsigned_abs() - 1) << 1, width);
                left -= 1;
            }
            (0..left).for_each(|_| bits.push(0, width));
        }
    }
}
