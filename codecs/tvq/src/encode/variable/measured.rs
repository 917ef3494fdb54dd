//! What measured blocks come to at a price, for every number of codebooks that may be kept.

use cvr_groups::best;

use cvr_groups::{Direct, Expected};

/// Errors of some blocks by number of codes, in units of sums.
pub struct Measured {
    expected: Expected,
    /// Bits of a code.
    width: f64,
    /// Numbers of codebooks, none included.
    counts: usize,
    /// Block by block, by number of codes.
    errors: Vec<f64>,
    /// Block by block, by number of codebooks: behind how many codes a block is best coded directly.
    behind: Vec<u8>,
}

/// What blocks come to.
#[derive(Copy, Clone, Default)]
pub struct Found {
    pub error: f64,
    pub codes: u64,
    /// Blocks that keep codes, or are coded directly.
    pub open: u64,
    /// Bits of what is coded directly.
    pub direct_bits: f64,
}

impl Found {
    fn add(&mut self, error: f64, codes: u8, direct_bits: f64) {
        self.error += error;
        self.codes += u64::from(codes);
        self.open += u64::from(codes > 0 || direct_bits > 0.0);
        self.direct_bits += direct_bits;
    }
}

impl Measured {
    /// Of errors by count of codebooks, and then by block.
    #[must_use]
    pub fn of(errors: &[Vec<f64>], width: u32, expected: Expected) -> Self {
        let (blocks, width) = (errors.first().map_or(0, Vec::len), f64::from(width));
        let by_block: Vec<f64> =
            (0..blocks).flat_map(|i| errors.iter().map(move |of_book| of_book[i])).collect();
        let counts = errors.len();
        let behind =
            by_block.chunks_exact(counts).flat_map(|errors| Expected::behind(errors, width)).collect();
        Self { expected, width, counts, errors: by_block, behind }
    }

    /// Blocks.
    #[must_use]
    pub const fn blocks(&self) -> usize {
        self.errors.len() / self.counts
    }

    /// By number of codebooks kept: what blocks come to where each keeps what pays.
    #[must_use]
    pub fn at(&self, price: f64) -> Vec<Found> {
        let code_price = price * self.width;
        let prices = vec![code_price; self.counts];
        let mut found = vec![Found::default(); self.counts];
        let of_blocks = self.errors.chunks_exact(self.counts).zip(self.behind.chunks_exact(self.counts));
        for (errors, behind) in of_blocks {
            let mut known: Option<(u8, Option<Direct>)> = None;
            best(
                |n| errors[n],
                &prices,
                (&[], price, 1),
                |m, choice| {
                    let (codes, count) = (behind[m], choice.codes);
                    let direct = match known {
                        Some((of, direct)) if of == codes => direct,
                        _ => self.expected.direct(errors[usize::from(codes)], price),
                    };
                    known = Some((codes, direct));
                    let cost = choice.error + code_price * f64::from(count);
                    match direct.filter(|d| d.cost + code_price * f64::from(codes) < cost) {
                        Some(direct) => found[m].add(direct.error, codes, direct.bits),
                        None => found[m].add(choice.error, count, 0.0),
                    }
                },
            );
        }
        found
    }

    /// The same where all codebooks are kept.
    #[must_use]
    pub fn all_at(&self, price: f64) -> Found {
        let code_price = price * self.width;
        let mut found = Found::default();
        let of_blocks = self.errors.chunks_exact(self.counts).zip(self.behind.chunks_exact(self.counts));
        for (errors, behind) in of_blocks {
            let of_count = |(n, error): (usize, &f64)| (error + code_price * n as f64, n);
            let costs = errors.iter().enumerate().map(of_count);
            let (cost, count) = costs.fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a });
            let codes = behind[self.counts - 1];
            let direct = self.expected.direct(errors[usize::from(codes)], price);
            match direct.filter(|d| d.cost + code_price * f64::from(codes) < cost) {
                Some(direct) => found.add(direct.error, codes, direct.bits),
                None => found.add(errors[count], count as u8, 0.0),
            }
        }
        found
    }
}
