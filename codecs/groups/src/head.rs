//! The head of a group: two words.

use crate::bits::width_of;

/// Of planes: the group has no records.
const NONE: u32 = 7;

/// Which blocks of a group have records.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Records {
    /// None: every block is its group's base. The group has no words.
    None,
    /// Those that the mask in the group's first two words names.
    Named,
    /// All: there is no mask.
    All,
}

/// The head of a group.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Head {
    /// First word of the group in its frame. Escapes lie before it.
    pub start: u32,
    /// Code that means count from, and the mean of blocks without a record.
    pub base: u32,
    /// Bits of a mean beyond the base.
    pub mean_bits: u32,
    /// Which blocks have records.
    pub records: Records,
    /// Planes of the counts of codes.
    pub planes: u32,
    /// If any block is escaped: least bits of a voxel, and planes of the bits beyond these.
    pub escapes: Option<[u32; 2]>,
}

impl Head {
    /// Reads a head.
    #[must_use]
    #[inline]
    pub const fn of(start: u32, form: u32) -> Self {
        let planes = form >> 21 & 7;
        let records = match (planes, form >> 24 & 1) {
            (NONE, _) => Records::None,
            (_, 0) => Records::Named,
            _ => Records::All,
        };
        let escapes = match form >> 29 {
            0 => None,
            planes => Some([(form >> 25 & 15) + 1, planes - 1]),
        };
        Self { start, base: form & 0xffff, mean_bits: form >> 16 & 31, records, planes, escapes }
    }

    /// As a stream holds it.
    #[must_use]
    pub fn words(self) -> [u32; 2] {
        let planes = if self.records == Records::None { NONE } else { self.planes };
        let escapes = self.escapes.map_or(0, |[least, planes]| (least - 1) << 25 | (planes + 1) << 29);
        let all = u32::from(self.records == Records::All) << 24;
        [self.start, self.base | self.mean_bits << 16 | planes << 21 | all | escapes]
    }
}

/// Planes that hold numbers up to `most`.
#[must_use]
#[inline]
pub const fn planes_of(most: u32) -> u32 {
    width_of(most)
}

/// Words of a plane of so many bits: one or two.
#[must_use]
#[inline]
pub const fn plane_words(bits: u32) -> u32 {
    if bits > 32 { 2 } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_comes_back() {
        for records in [Records::None, Records::Named, Records::All] {
            for (mean_bits, planes) in [(0, 0), (16, 6), (5, 3)] {
                for escapes in [None, Some([1, 0]), Some([16, 4]), Some([7, 2])] {
                    let planes = if records == Records::None { NONE } else { planes };
                    let head = Head { start: 99, base: 65535, mean_bits, records, planes, escapes };
                    let [start, form] = head.words();
                    assert_eq!(Head::of(start, form), head);
                }
            }
        }
    }
}
