//! The classes of a group of places: where each record lies, and its coefficients.

use crate::blocks::classes::FORMAT_BITS;
use crate::blocks::shape::KIND;
use crate::blocks::write::CODE_BITS;
use cvr_core::kit::number as take;

/// All slots.
pub const ALL: u32 = 0x7f;

/// The classes of a group.
#[derive(Copy, Clone, Debug)]
pub struct Group {
    /// Bit of the first record.
    records: u32,
    /// Format of each class, and bits of its records.
    formats: [u32; 4],
    lengths: [u32; 4],
    /// Bits 0 and 1 of the class of each place.
    even: [u32; 3],
    odd: [u32; 3],
}

/// Bits and format of the coefficients of a place.
#[derive(Copy, Clone, Debug)]
pub struct Record {
    bit: u32,
    format: u32,
}

/// Bits of a record.
#[inline]
const fn length(format: u32) -> u32 {
    if format & 0x8000 != 0 {
        return 7 + (format & 7) * (format >> 5 & 31);
    }
    3 * ((format & 31) + (format >> 5 & 31)) + (format >> 10)
}

/// One plane of a group.
#[inline]
fn plane(words: &[u32], first: usize, bit: u32, places: u32) -> [u32; 3] {
    [take(words, first, bit, 32), take(words, first, bit + 32, 32), take(words, first, bit + 64, places - 64)]
}

impl Group {
    /// All coefficients are 0.
    pub const EMPTY: Self = Self { records: 0, formats: [0; 4], lengths: [0; 4], even: [0; 3], odd: [0; 3] };

    /// The group of so many places that begins at a bit.
    #[inline]
    pub fn read(words: &[u32], first: usize, start: u32, places: u32) -> Self {
        let code = take(words, first, start, CODE_BITS);
        let (planes, bare) = (code & 3, code >> 2);
        let mut bit = start + CODE_BITS;
        let mut group = Self::EMPTY;
        for class in bare..1 << planes {
            let format = take(words, first, bit, FORMAT_BITS);
            group.formats[class as usize] = format;
            group.lengths[class as usize] = length(format);
            bit += FORMAT_BITS;
        }
        if planes > 0 {
            group.even = plane(words, first, bit, places);
            bit += places;
        }
        if planes > 1 {
            group.odd = plane(words, first, bit, places);
            bit += places;
        }
        group.records = bit;
        group
    }

    /// Whether the group of so many places that begins at a bit is sound and ends before bit `end`.
    pub fn is_inside(words: &[u32], first: usize, start: u32, places: u32, end: u64) -> bool {
        let fits = |bit: u64| bit <= end;
        if !fits(u64::from(start + CODE_BITS)) {
            return false;
        }
        let code = take(words, first, start, CODE_BITS);
        let (planes, bare) = (code & 3, code >> 2);
        let formats = (1 << planes) - bare;
        if planes > 2 || !fits(u64::from(start + CODE_BITS + FORMAT_BITS * formats + planes * places)) {
            return false;
        }
        let group = Self::read(words, first, start, places);
        let counts = group.counts([u32::MAX; 3], places);
        let all: u32 = counts.iter().zip(group.lengths).map(|(count, length)| count * length).sum();
        fits(u64::from(group.records) + u64::from(all))
    }

    /// How many of the first `count` places are of each class. `below` has their bits.
    #[inline]
    fn counts(&self, below: [u32; 3], count: u32) -> [u32; 4] {
        let (mut even, mut odd, mut both) = (0, 0, 0);
        for (below, (e, o)) in below.into_iter().zip(self.even.into_iter().zip(self.odd)) {
            even += (e & below).count_ones();
            odd += (o & below).count_ones();
            both += (e & o & below).count_ones();
        }
        [count + both - even - odd, even - both, odd - both, both]
    }

    /// The record of a place.
    #[inline]
    pub fn record(&self, place: u32) -> Record {
        let (bit, word) = (1 << (place & 31), (place >> 5) as usize);
        let below = [0, 1, 2].map(|w| match w {
            w if w < word => u32::MAX,
            w if w == word => bit - 1,
            _ => 0,
        });
        let counts = self.counts(below, place);
        let before: u32 = counts.iter().zip(self.lengths).map(|(count, length)| count * length).sum();
        let class = usize::from(self.even[word] & bit != 0) + 2 * usize::from(self.odd[word] & bit != 0);
        Record { bit: self.records + before, format: self.formats[class] }
    }
}

impl Record {
    /// Whether all coefficients are 0.
    #[inline]
    pub const fn is_empty(self) -> bool {
        self.format == 0
    }

    /// The quantised coefficients by slot. Only those of the slots in `wanted` are read, the others are 0.
    #[inline]
    pub fn coefficients(self, words: &[u32], first: usize, wanted: u32) -> [i32; 7] {
        let Self { bit: mut at, format } = self;
        let is_sparse = format & 0x8000 != 0;
        let widths = [format & 31, format >> 5 & 31, format >> 10];
        let mut mask = ALL;
        if is_sparse {
            mask = take(words, first, at, 7);
            at += 7;
        }
        // A stream may set more bits than it has room for.
        let mut left = if is_sparse { format & 7 } else { 7 };
        let mut out = [0; 7];
        for (slot, out) in out.iter_mut().enumerate() {
            if mask >> slot & 1 == 0 || left == 0 {
                continue;
            }
            left -= 1;
            let width = if is_sparse { widths[1] } else { widths[KIND[slot]] };
            if wanted >> slot & 1 == 1 && (width > 0 || is_sparse) {
                let number = take(words, first, at, width);
                *out = if is_sparse {
                    let magnitude = (number >> 1) as i32 + 1;
                    if number & 1 == 1 { -magnitude } else { magnitude }
                } else {
                    (number << (32 - width)) as i32 >> (32 - width)
                };
            }
            at += width;
        }
        out
    }
}
