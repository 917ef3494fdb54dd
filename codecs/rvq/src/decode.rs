//! Voxels out of codes and codewords: the twin of decode.wgsl, but that cells are the kit's here. This one defines the codec.

use cvr_codebook::pack::unpack;
use cvr_core::kit::{BlockFrame, BlockGrid};

use crate::stream::{BASE, EDGE, Entries, Geometry, MOST_STAGES, TOP};

/// One frame of a stream at a level.
#[derive(Copy, Clone, Debug)]
pub struct Frame<'a> {
    /// Codes: `geometry.index_words()` words.
    pub index: &'a [u32],
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

/// First entries of a block's codewords.
pub type Codewords = [u32; MOST_STAGES as usize];

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

    /// Code of a block at a stage.
    ///
    /// # Panics
    /// When there is no such block or stage.
    #[must_use]
    #[inline]
    pub fn code(&self, block: [u32; 3], stage: usize) -> u32 {
        let g = self.geometry;
        unpack(self.index, g.index_bits, g.grids[0].number(block) * g.stages as usize + stage)
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

/// A head is the first entry of each of a block's codewords.
impl BlockFrame for Frame<'_> {
    type Head = Codewords;

    fn grid(&self) -> &BlockGrid {
        &self.geometry.grids[self.resolution]
    }

    fn channels(&self) -> usize {
        self.geometry.channels as usize
    }

    fn head(&self, block: [u32; 3]) -> Codewords {
        let g = self.geometry;
        let (first, size) = (g.firsts()[self.resolution], g.codeword_entries(self.resolution));
        let mut head = [0; MOST_STAGES as usize];
        for (s, head) in head.iter_mut().enumerate().take(self.stages) {
            *head = first + (s as u32 * g.codewords + self.code(block, s)) * size;
        }
        head
    }

    #[inline]
    fn voxel(&self, head: Codewords, inside: [u32; 3], c: usize) -> f32 {
        let place = self.grid().place(inside);
        let terms = head.iter().zip(self.units).take(self.stages);
        self.value(BASE + terms.map(|(first, units)| self.term(*first, place, c, *units)).sum::<i32>())
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
