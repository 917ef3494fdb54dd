//! Decodes voxels and cells from means and sums of codewords. The twin of decode.wgsl, with one difference: cells are
//! assembled block by block here, and codebook by codebook there, which keeps neighbouring invocations together. This
//! code defines the codec.

mod check;
mod former;
mod interleave;
pub(crate) mod reader;

use cvr_core::kit::{FetchVoxels, Voxel};
use cvr_core::render::Cell;
use cvr_groups::{Groups, Scale, part_value};

use crate::stream::geometry::{
    BOOK_WORDS, EDGE, GROUP, Geometry, MOST_BOOKS, Payload, TABLE_HEAD, TOP, VOXELS, number,
};
use crate::stream::table::Partition;

/// One frame of a stream at a stage.
#[derive(Copy, Clone, Debug)]
pub struct Frame<'a> {
    /// Tables of all sub-volumes.
    pub tables: &'a [u32],
    /// Entries of all codebooks.
    pub codebook: &'a [u32],
    /// Means and codes. With the payload `fixed` they are ordered block by block, except while a stream is checked.
    pub index: &'a [u32],
    /// Heads of all groups; none for the payload `fixed`.
    pub heads: &'a [u32],
    /// Number of partitions to sum, the mean included: 1 to 4. More means all.
    pub stages: u32,
    /// Sizes.
    pub geometry: &'a Geometry,
}

/// Sums of one block at the ends of a cell's four rows along x. In a row's number, bit 0 is y and bit 1 is z.
pub type Ends = [[i32; 2]; 4];

/// The terms of a block's sum, for any place in the block.
#[derive(Copy, Clone, Debug)]
pub struct Terms {
    /// Its mean.
    pub mean: i32,
    /// Codewords: first word of the codebook in the tables, and the code.
    pub codes: [(u32, u32); MOST_BOOKS as usize],
    /// Number of codewords.
    pub count: usize,
    /// What is coded directly: first word of the escape, and bits of a voxel; 0 bits where nothing is.
    pub rest: (u32, u32),
}

impl Frame<'_> {
    /// Value of a sum, in data units. It is the codec's only floating-point expression.
    #[must_use]
    #[inline]
    pub fn value(&self, sum: i32) -> f32 {
        self.geometry.quantiser.value(sum.clamp(0, TOP) as u32)
    }

    /// A number of `width` bits (at most 16), at bit `bit`, counted from word `first` of the indices.
    ///
    /// # Panics
    /// When it lies outside.
    #[must_use]
    #[inline]
    pub fn number(&self, first: u32, bit: u64, width: u32) -> u32 {
        cvr_groups::number(self.index, first, bit, width)
    }

    /// Entry `i` of the codebooks.
    ///
    /// # Panics
    /// When there is none.
    #[must_use]
    #[inline]
    pub fn entry(&self, i: usize) -> i32 {
        let (bits, lanes_log2) = (self.geometry.entry_bits, self.geometry.lanes_log2());
        let lane = i as u32 & ((1 << lanes_log2) - 1);
        let code = (self.codebook[i >> lanes_log2] >> (lane * bits)) & ((1 << bits) - 1);
        code as i32 - (1 << (bits - 1))
    }

    /// Bits of a code.
    #[inline]
    const fn width(form: u32) -> u32 {
        form & 31
    }

    /// Whether the codebook belongs to a partition that is summed.
    #[inline]
    const fn shown(&self, form: u32) -> bool {
        form >> 16 < self.stages
    }

    /// The value that one codeword adds at a place.
    ///
    /// # Panics
    /// When there is no such codebook or codeword.
    #[must_use]
    #[inline]
    pub fn term(&self, book: u32, code: u32, place: usize) -> i32 {
        let form = self.tables[book as usize + 2];
        let first = self.tables[book as usize] as usize;
        self.entry(first + code as usize * VOXELS + place) * Scale::of_form(form).units() as i32
    }

    /// First word of the table of a block's sub-volume.
    #[must_use]
    #[inline]
    pub fn table(&self, block: [u32; 3]) -> u32 {
        let g = self.geometry;
        let sub = [0, 1, 2].map(|a| block[a] / g.sub_blocks[a]);
        number(sub, g.sub_grid.to_array()) as u32 * g.table_words()
    }

    /// A block's mean out of its code.
    #[must_use]
    #[inline]
    pub fn mean(&self, table: u32, code: u32) -> i32 {
        (code << self.tables[table as usize]) as i32
    }

    /// The terms of a block if every block has one code of every codebook. The indices hold mean and codes block by
    /// block.
    fn fixed(&self, block: [u32; 3], channel: u32) -> Terms {
        let (g, table) = (self.geometry, self.table(block));
        let word = |i: u32| self.tables[(table + i) as usize];
        let (first, size) = g.sub_volume([0, 1, 2].map(|a| block[a] / g.sub_blocks[a]));
        let n = number([0, 1, 2].map(|a| block[a] - first[a]), size) as u64;
        let books = (0..g.books).map(|b| table + TABLE_HEAD + BOOK_WORDS * b);
        let form = |book: u32| self.tables[book as usize + 2];
        let start = word(3) + channel * word(4);
        let width = word(1);
        let bits = width + books.clone().map(|book| Self::width(form(book))).sum::<u32>();
        let mut bit = n * u64::from(bits);
        let mean = self.mean(table, word(2) + self.number(start, bit, width));
        let mut terms = Terms::new(mean);
        bit += u64::from(width);
        for book in books {
            let width = Self::width(form(book));
            if self.shown(form(book)) {
                terms.push(book, self.number(start, bit, width));
            }
            bit += u64::from(width);
        }
        terms
    }

    /// The groups of the payload `variable`.
    #[must_use]
    #[inline]
    pub const fn groups(&self) -> Groups<'_> {
        Groups { heads: self.heads, words: self.index, parts: 1 }
    }

    /// What a block is made of where each keeps codes of the first so many codebooks: its group says which. An escape belongs to
    /// the last stage.
    fn kept(&self, block: [u32; 3], channel: u32) -> Terms {
        let (g, table) = (self.geometry, self.table(block));
        let group = block.map(|b| b / GROUP);
        let (first, size) = g.group(group);
        let n = number([0, 1, 2].map(|a| block[a] - first[a]), size) as u32;
        let place = channel as usize * g.groups.voxels() as usize + number(group, g.groups.to_array());
        let (groups, width) = (self.groups(), self.tables[table as usize + 1]);
        let kept = groups.block(place, n, size.iter().product(), width);
        let mut terms = Terms::new(self.mean(table, kept.mean));
        for b in 0..kept.count {
            let book = table + TABLE_HEAD + BOOK_WORDS * b;
            if self.shown(self.tables[book as usize + 2]) {
                terms.push(book, groups.code(&kept, b, width));
            }
        }
        if self.stages > Partition::High as u32 {
            terms.rest = (kept.rest, kept.rest_bits);
        }
        terms
    }

    /// The terms of a block's sum.
    ///
    /// # Panics
    /// When there is no such block.
    #[must_use]
    pub fn terms(&self, block: [u32; 3], channel: u32) -> Terms {
        match self.geometry.payload {
            Payload::Variable => self.kept(block, channel),
            Payload::Fixed => self.fixed(block, channel),
        }
    }

    /// The sum at one place of a block.
    ///
    /// # Panics
    /// When there is no such place.
    #[must_use]
    #[inline]
    pub fn sum(&self, terms: &Terms, place: usize) -> i32 {
        let codes = terms.codes[..terms.count].iter();
        let sum = terms.mean + codes.map(|(book, code)| self.term(*book, *code, place)).sum::<i32>();
        sum + self.rest(terms, place)
    }

    /// What is coded directly, at a place.
    #[inline]
    fn rest(&self, terms: &Terms, place: usize) -> i32 {
        let (first, bits) = terms.rest;
        if bits == 0 { 0 } else { part_value(self.index, first, bits, place) }
    }

    /// Sums of a block from place `low` to place `high`.
    ///
    /// # Panics
    /// When there is no such place.
    #[must_use]
    #[inline]
    pub fn ends(&self, terms: &Terms, low: [u32; 3], high: [u32; 3]) -> Ends {
        let mut sums = [[terms.mean; 2]; 4];
        let mut add = |at: &dyn Fn(usize) -> i32| {
            for (row, sums) in sums.iter_mut().enumerate() {
                let y = if row & 1 == 1 { high[1] } else { low[1] };
                let z = if row & 2 == 2 { high[2] } else { low[2] };
                sums[0] += at(place([low[0], y, z]));
                sums[1] += at(place([high[0], y, z]));
            }
        };
        for &(book, code) in &terms.codes[..terms.count] {
            add(&|place| self.term(book, code, place));
        }
        if terms.rest.1 > 0 {
            add(&|place| self.rest(terms, place));
        }
        sums
    }
}

impl FetchVoxels for Frame<'_> {
    fn channels(&self) -> usize {
        self.geometry.channels as usize
    }

    fn fetch(&self, p: [u32; 3]) -> Voxel {
        let block = p.map(|p| p / EDGE);
        let place = place([0, 1, 2].map(|a| p[a] - block[a] * EDGE));
        let mut out = [0.0; 4];
        for (c, out) in (0..self.geometry.channels).zip(&mut out) {
            *out = self.value(self.sum(&self.terms(block, c), place));
        }
        out
    }

    /// Finds the terms of each of the one to eight blocks once.
    fn fetch_cell(&self, p: [u32; 3], q: [u32; 3]) -> Cell {
        // Axes along which the cell reaches into another block.
        let crossed = [0, 1, 2].map(|a| u32::from(p[a] / EDGE != q[a] / EDGE));
        let shifts = [0, crossed[0], crossed[0] + crossed[1]];
        let mut out = [[0.0; 4]; 8];
        for c in 0..self.geometry.channels {
            for k in 0..1_u32 << (shifts[2] + crossed[2]) {
                let side = [0, 1, 2].map(|a| (k >> shifts[a]) & crossed[a]);
                let from = [0, 1, 2].map(|a| if side[a] == 0 { p[a] } else { q[a] });
                let to = [0, 1, 2].map(|a| if side[a] == crossed[a] { q[a] } else { p[a] });
                let terms = self.terms(from.map(|v| v / EDGE), c);
                let sums = self.ends(&terms, from.map(|v| v % EDGE), to.map(|v| v % EDGE));
                for (i, out) in out.iter_mut().enumerate() {
                    // Along each crossed axis, the corner's end must lie in this block.
                    if (0..3).all(|a| crossed[a] == 0 || (i >> a & 1) as u32 == side[a]) {
                        out[c as usize] = self.value(sums[i >> 1][i & 1]);
                    }
                }
            }
        }
        out
    }

    /// Finds the terms of each block once.
    fn fetch_row(&self, start: [u32; 3], out: &mut [f32]) {
        let channels = self.channels();
        let (mut p, mut rest) = (start, out);
        while !rest.is_empty() {
            let (block, inside) = self.geometry.grid.split(p);
            let run = ((EDGE - inside[0]) as usize).min(rest.len() / channels);
            let (part, later) = rest.split_at_mut(run * channels);
            for c in 0..channels {
                let terms = self.terms(block, c as u32);
                let first = place(inside);
                for (x, out) in part[c..].iter_mut().step_by(channels).enumerate() {
                    *out = self.value(self.sum(&terms, first + x));
                }
            }
            p[0] += run as u32;
            rest = later;
        }
    }
}

impl Terms {
    /// A mean, and nothing else yet.
    const fn new(mean: i32) -> Self {
        Self { mean, codes: [(0, 0); MOST_BOOKS as usize], count: 0, rest: (0, 0) }
    }

    fn push(&mut self, book: u32, code: u32) {
        self.codes[self.count] = (book, code);
        self.count += 1;
    }
}

/// The number of a voxel in its block.
#[must_use]
#[inline]
pub fn place(inside: [u32; 3]) -> usize {
    number(inside, [EDGE; 3])
}
