//! Which of its codes a block keeps, and whether it is escaped behind them: the least of `error + price · bits`.

use crate::escape::part_words;

/// A way to escape a block, and what it leaves.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Codes before it.
    pub codes: u8,
    /// Bits of a voxel.
    pub bits: u8,
    /// Squared error of the block then.
    pub error: f32,
}

/// What a block keeps.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Choice {
    /// Codes.
    pub codes: u8,
    /// Bits of a voxel of its escape; 0 without one.
    pub bits: u8,
    /// Squared error.
    pub error: f64,
}

impl Choice {
    /// Bits of a voxel of its escape, if it has one.
    #[must_use]
    #[inline]
    pub const fn escape(&self) -> Option<u32> {
        if self.bits == 0 { None } else { Some(self.bits as u32) }
    }
}

/// Bits of an escape of `parts` parts.
#[must_use]
#[inline]
pub const fn escape_bits(bits: u32, parts: u32) -> u32 {
    32 * parts * part_words(bits)
}

/// For each number `m` of codebooks, from none to all, what a block keeps of its first `m` codes and of the candidates behind no
/// more than these: the least of `error + price · bits`, of equal ones the fewest codes. `errors[n]` is what `n` codes leave,
/// `prices[m]` the price of a code where `m` codebooks are kept, `price` that of a bit. Candidates are in the order of their
/// codes.
pub fn best(
    errors: impl Fn(usize) -> f64,
    prices: &[f64],
    (candidates, price, parts): (&[Candidate], f64, u32),
    mut each: impl FnMut(usize, Choice),
) {
    let (mut count, mut least) = (0, f64::INFINITY);
    let (mut next, mut escape, mut least_escaped) = (0, 0, f64::INFINITY);
    for (m, code_price) in prices.iter().enumerate() {
        // Costs at the price before say nothing at another.
        let anew = m == 0 || *code_price != prices[m - 1];
        if anew {
            (least, least_escaped, next) = (f64::INFINITY, f64::INFINITY, 0);
        }
        for n in if anew { 0 } else { m }..=m {
            let cost = errors(n) + code_price * n as f64;
            if cost < least {
                (count, least) = (n, cost);
            }
        }
        while let Some(c) = candidates.get(next).filter(|c| usize::from(c.codes) <= m) {
            let bits = f64::from(escape_bits(c.bits.into(), parts));
            let cost = f64::from(c.error) + code_price * f64::from(c.codes) + price * bits;
            if cost < least_escaped {
                (escape, least_escaped) = (next, cost);
            }
            next += 1;
        }
        each(
            m,
            if least_escaped < least {
                let Candidate { codes, bits, error } = candidates[escape];
                Choice { codes, bits, error: error.into() }
            } else {
                Choice { codes: count as u8, bits: 0, error: errors(count) }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(price: f64, prices: &[f64], candidates: &[Candidate]) -> Vec<(u8, u8)> {
        let mut found = Vec::new();
        best(
            |n| [900.0, 600.0, 550.0][n],
            prices,
            (candidates, price, 1),
            |_, c| found.push((c.codes, c.bits)),
        );
        found
    }

    #[test]
    fn a_block_keeps_what_pays() {
        let of = |price: f64| chosen(price, &[price; 3], &[]).into_iter().map(|c| c.0).collect::<Vec<_>>();
        assert_eq!((of(10.0), of(100.0), of(400.0)), (vec![0, 1, 2], vec![0, 1, 1], vec![0, 0, 0]));
        // Codes of a wider codebook cost more, and so do then those before it.
        let counts: Vec<u8> = chosen(1.0, &[100.0, 100.0, 400.0], &[]).into_iter().map(|c| c.0).collect();
        assert_eq!(counts, [0, 1, 0]);
    }

    #[test]
    fn an_escape_is_taken_where_it_pays_and_not_before_its_codes() {
        let candidates = [
            Candidate { codes: 0, bits: 4, error: 10.0 },
            Candidate { codes: 1, bits: 1, error: 200.0 },
            Candidate { codes: 1, bits: 2, error: 50.0 },
        ];
        let of = |price: f64| chosen(price, &[8.0 * price; 3], &candidates);
        assert_eq!(of(0.01), [(0, 4); 3]);
        assert_eq!(of(1.0), [(0, 4), (1, 2), (1, 2)]);
        assert_eq!(of(3.0), [(0, 4), (1, 1), (1, 1)]);
        assert_eq!(of(6.0), [(0, 0), (1, 0), (2, 0)]);
    }
}
