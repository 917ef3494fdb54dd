//! Voxels out of means, codes and codewords: the twin of decode.wgsl, but that cells are the kit's here. This one defines the codec.

use cvr_codebook::pack::unpack;
use cvr_core::kit::{BlockFrame, BlockGrid};
use cvr_groups::{Groups, part_range, part_value, part_words};

use crate::stream::{BASE, EDGE, Entries, Geometry, MOST_STAGES, Payload, TOP};

/// One frame of a stream at a level.
#[derive(Copy, Clone, Debug)]
pub struct Frame<'a> {
    /// Codes: `geometry.index_words()` words. Under the payload `variable` groups.
    pub index: &'a [u32],
    /// Heads of the groups; none under the payload `fixed`.
    pub heads: &'a [u32],
    /// Codes of means count two to this power.
    pub mean_shift: u32,
    /// Codewords of all resolutions.
    pub codebook: &'a [u32],
    /// Units of the sums that an entry of each stage counts.
    pub units: &'a [i32],
    /// 0 for blocks of 4³ voxels, 1 for 2³, 2 for one.
    pub resolution: usize,
    /// Stages that are summed: 1 to all.
    pub stages: usize,
    /// Sizes.
    pub geometry: &'a Geometry,
}

/// What a block is the sum of.
#[derive(Copy, Clone, Debug)]
pub struct Terms {
    /// What its sums begin with, for each channel.
    pub base: [i32; 3],
    /// Its codes, stage by stage.
    pub codes: [u16; MOST_STAGES as usize],
    /// How many there are.
    pub count: usize,
    /// What is coded directly: first word of the escape, and bits of a voxel; 0 bits where nothing is.
    pub rest: (u32, u32),
}

/// Channel `c` of an entry: its code, counted from the middle one, in units of its stage's scale.
#[must_use]
#[inline]
pub fn centred(entries: Entries, words: &[u32], entry: usize, c: usize) -> i32 {
    match entries {
        Entries::Bits8 => ((words[entry >> 2] >> (8 * (entry & 3))) & 0xff) as i32 - 0x80,
        Entries::Bits16 => ((words[entry >> 1] >> (16 * (entry & 1))) & 0xffff) as i32 - 0x8000,
        Entries::Colours => {
            let (first, width) = [(0, 11), (11, 11), (22, 10)][c];
            let code = (words[entry] >> first) & ((1 << width) - 1);
            (code << (16 - width)) as i32 - 0x8000
        }
    }
}

impl Frame<'_> {
    /// Value of a sum, in data units: the only float expression of the codec.
    #[must_use]
    #[inline]
    pub fn value(&self, sum: i32) -> f32 {
        self.geometry.quantiser.value(sum.clamp(0, TOP) as u32)
    }

    /// The groups of the payload `variable`.
    #[must_use]
    #[inline]
    pub const fn groups(&self) -> Groups<'_> {
        Groups { heads: self.heads, words: self.index, parts: self.geometry.parts() }
    }

    /// What a block is the sum of at this level. An escape belongs to the last stage.
    ///
    /// # Panics
    /// When there is no such block.
    #[must_use]
    pub fn terms(&self, block: [u32; 3]) -> Terms {
        let g = self.geometry;
        let mut codes = [0; MOST_STAGES as usize];
        match g.payload {
            Payload::Fixed => {
                let first = g.grids[0].number(block) * g.stages as usize;
                for (s, code) in codes.iter_mut().enumerate().take(self.stages) {
                    *code = unpack(self.index, g.index_bits, first + s) as u16;
                }
                Terms { base: [BASE; 3], codes, count: self.stages, rest: (0, 0) }
            }
            Payload::Variable => {
                let group = block.map(|b| b / cvr_groups::EDGE);
                let (first, [x, y, z]) = g.group(group);
                let p = [0, 1, 2].map(|a| block[a] - first[a]);
                let along = g.groups;
                let number = (group[2] * along.y() + group[1]) * along.x() + group[0];
                let n = (p[2] * y + p[1]) * x + p[0];
                let groups = self.groups();
                let kept = groups.block(number as usize, n, x * y * z, g.index_bits);
                let count = self.stages.min(kept.count as usize);
                for (s, code) in codes.iter_mut().enumerate().take(count) {
                    *code = groups.code(&kept, s as u32, g.index_bits) as u16;
                }
                let whole = self.stages == g.stages as usize;
                let rest = if whole { (kept.rest, kept.rest_bits) } else { (0, 0) };
                Terms { base: g.mean(self.mean_shift, kept.mean), codes, count, rest }
            }
        }
    }

    /// What an escape adds to channel `c` of a voxel: at coarser resolutions the mean over its voxels, half a unit rounded up.
    fn rest(&self, (first, bits): (u32, u32), inside: [u32; 3], c: usize) -> i32 {
        let first = first + c as u32 * part_words(bits);
        let place = |[x, y, z]: [u32; 3]| ((z * EDGE + y) * EDGE + x) as usize;
        if self.resolution == 0 {
            return part_value(self.index, first, bits, place(inside));
        }
        let (log2, low) = (self.resolution as u32, part_range(self.index, first, bits).0);
        let edge = 1_u32 << log2;
        let voxel = |i: u32| {
            let corner = [i & (edge - 1), i >> log2 & (edge - 1), i >> (2 * log2)];
            place([0, 1, 2].map(|a| inside[a] * edge + corner[a]))
        };
        let above = |i: u32| (part_value(self.index, first, bits, voxel(i)) - low) as u32;
        let all: u32 = (0..1 << (3 * log2)).map(above).sum();
        low + ((all + (1 << (3 * log2 - 1))) >> (3 * log2)) as i32
    }

    /// What an entry at a place of a codeword adds to channel `c`.
    #[inline]
    fn term(&self, first: u32, place: usize, c: usize, units: i32) -> i32 {
        let entries = self.geometry.entries;
        let (entry, lane) = match entries {
            Entries::Bits8 | Entries::Bits16 => (place * self.geometry.channels as usize + c, 0),
            Entries::Colours => (place, c),
        };
        centred(entries, self.codebook, first as usize + entry, lane) * units
    }
}

impl BlockFrame for Frame<'_> {
    type Head = Terms;

    fn grid(&self) -> &BlockGrid {
        &self.geometry.grids[self.resolution]
    }

    fn channels(&self) -> usize {
        self.geometry.channels as usize
    }

    fn head(&self, block: [u32; 3]) -> Terms {
        self.terms(block)
    }

    #[inline]
    fn voxel(&self, head: Terms, inside: [u32; 3], c: usize) -> f32 {
        let (g, place) = (self.geometry, self.grid().place(inside));
        let (begun, size) = (g.firsts()[self.resolution], g.codeword_entries(self.resolution));
        let mut sum = head.base[c];
        for (s, (code, units)) in head.codes.iter().zip(self.units).enumerate().take(head.count) {
            let first = begun + (s as u32 * g.codewords + u32::from(*code)) * size;
            sum += self.term(first, place, c, *units);
        }
        if head.rest.1 > 0 {
            sum += self.rest(head.rest, inside, c);
        }
        self.value(sum)
    }
}

/// The words of codewords at half the resolution, `entries` of voxels in a cube of `edge`: each entry is the mean of eight.
/// Half a code is rounded up.
#[must_use]
pub fn halved(g: &Geometry, words: &[u32], resolution: usize) -> Vec<u32> {
    let edge = EDGE >> resolution;
    let half = edge / 2;
    let (per_voxel, entries) = (g.entries.per_voxel(g.channels) as usize, g.entries);
    let (from, to) = (g.codeword_entries(resolution) as usize, g.codeword_entries(resolution + 1) as usize);
    let parts = if entries == Entries::Colours { 3 } else { 1 };
    let mut packed = vec![0_u32; g.words(resolution + 1) as usize];
    for k in 0..g.table_codewords() as usize {
        for place in 0..(half * half * half) as usize {
            let p = [place as u32 % half, place as u32 / half % half, place as u32 / half / half];
            for e in 0..per_voxel {
                for part in 0..parts {
                    let corner = |i: u32| {
                        let q = [0, 1, 2].map(|a| 2 * p[a] + (i >> a & 1));
                        let place = ((q[2] * edge + q[1]) * edge + q[0]) as usize;
                        centred(entries, words, k * from + place * per_voxel + e, part)
                    };
                    // The lower bits of a colour's code are not stored: means are those of what is.
                    let step = 1 << entries.dropped(part);
                    let sum: i32 = (0..8).map(|i| corner(i) / step).sum();
                    set(entries, &mut packed, k * to + place * per_voxel + e, part, (sum + 4) >> 3);
                }
            }
        }
    }
    packed
}

/// Stores part `part` of an entry, counted from the middle code in steps of what is stored.
fn set(entries: Entries, words: &mut [u32], entry: usize, part: usize, centred: i32) {
    match entries {
        Entries::Bits8 => words[entry >> 2] |= ((centred + 0x80) as u32) << (8 * (entry & 3)),
        Entries::Bits16 => words[entry >> 1] |= ((centred + 0x8000) as u32) << (16 * (entry & 1)),
        Entries::Colours => {
            let (first, width) = [(0, 11), (11, 11), (22, 10)][part];
            words[entry] |= ((centred + (1 << (width - 1))) as u32) << first;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_lie_in_one_word() {
        let mut words = [0];
        for (part, centred) in [-1024, 1023, -3].into_iter().enumerate() {
            set(Entries::Colours, &mut words, 0, part, centred);
        }
        assert_eq!(words[0], 2047 << 11 | 509 << 22);
        let back = [0, 1, 2].map(|c| centred(Entries::Colours, &words, 0, c));
        assert_eq!(back, [-1024 * 32, 1023 * 32, -3 * 64]);
    }

    #[test]
    fn values_lie_side_by_side() {
        for (entries, all) in
            [(Entries::Bits8, [-128, 127, 0, 5, -1]), (Entries::Bits16, [-32768, 32767, 0, 5, -1])]
        {
            let mut words = [0; 3];
            all.into_iter().enumerate().for_each(|(i, value)| set(entries, &mut words, i, 0, value));
            assert_eq!([0, 1, 2, 3, 4].map(|i| centred(entries, &words, i, 0)), all);
        }
    }
}
