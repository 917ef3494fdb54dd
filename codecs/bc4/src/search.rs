//! The endpoints of a block: its range, or those with the least squared error.
//!
//! All arithmetic is on integers, in parts of a code, so a block gets the same endpoints on every machine. Of equally
//! good endpoints, those tried first are kept. Of equally near levels, the lowest index is kept.

use crate::block::{Ends, PARTS, TEXELS, TOP, pack};

/// How endpoints are found.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Quality {
    /// Minimum and maximum of the block, in the mode with eight levels.
    Range,
    /// Least squares from several starts in both modes, then every pair of endpoints around the best.
    Search,
}

impl Quality {
    /// The values of the setting.
    pub const NAMES: &'static [&'static str] = &["range", "search"];

    /// The quality of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "range" => Some(Self::Range),
            "search" => Some(Self::Search),
            _ => None,
        }
    }
}

/// Levels of the voxels of a block, in parts of a code, 0 to [`TOP`].
type Wanted = [i16; TEXELS];

/// The block for these levels (x fastest), as two words.
#[must_use]
pub fn encode_block(wanted: &Wanted, quality: Quality) -> [u32; 2] {
    let range = ends_of_range(wanted);
    let ends = match quality {
        Quality::Range => range,
        Quality::Search => search(wanted, range),
    };
    pack(ends, &nearest(wanted, &ends.levels()))
}

/// Codes that enclose the block.
fn ends_of_range(wanted: &Wanted) -> Ends {
    let (low, high) = bounds(wanted.iter().copied()).unwrap_or((0, 0));
    Ends([(high + PARTS as i16 - 1) / PARTS as i16, low / PARTS as i16].map(|code| code as u8))
}

fn bounds(wanted: impl Iterator<Item = i16>) -> Option<(i16, i16)> {
    wanted.fold(None, |range, w| {
        Some(range.map_or((w, w), |(low, high): (i16, i16)| (low.min(w), high.max(w))))
    })
}

/// Squared error of a block with nearest levels. It is at most 16 · 8925², which fits into 32 bits.
fn squared_error(wanted: &Wanted, levels: &[i16; 8]) -> u32 {
    let mut nearest = [i16::MAX; TEXELS];
    for level in levels {
        for (nearest, wanted) in nearest.iter_mut().zip(wanted) {
            *nearest = (*nearest).min((wanted - level).abs());
        }
    }
    nearest.iter().map(|d| (i32::from(*d) * i32::from(*d)) as u32).sum()
}

/// The lowest index of the nearest level of each voxel.
fn nearest(wanted: &Wanted, levels: &[i16; 8]) -> [u8; TEXELS] {
    wanted.map(|wanted| {
        let distances = levels.map(|level| (wanted - level).abs());
        (1..8).fold(0, |best, i| if distances[i as usize] < distances[best as usize] { i } else { best })
    })
}

/// The best endpoints so far.
struct Best<'a> {
    wanted: &'a Wanted,
    ends: Ends,
    error: u32,
}

impl Best<'_> {
    /// The better of two. The first if they are equally good.
    fn or(self, other: Self) -> Self {
        if other.error < self.error { other } else { self }
    }

    /// Whether these endpoints are better than the best. If so, they become the best.
    fn improves(&mut self, ends: Ends) -> bool {
        let error = squared_error(self.wanted, &ends.levels());
        let better = error < self.error;
        if better {
            (self.ends, self.error) = (ends, error);
        }
        better
    }
}

/// Starts from the range and from narrower ranges in the mode with eight levels. Then, in the mode with six, it leaves
/// voxels near 0 and 255 to the extremes.
fn search(wanted: &Wanted, range: Ends) -> Ends {
    let mut best = in_mode(wanted, range);
    let [high, low] = range.0;
    let inset = high.saturating_sub(low) / 8;
    for (from_low, from_high) in [(inset, 0), (0, inset), (inset, inset)] {
        if inset > 0 && best.error > 0 {
            best = best.or(in_mode(wanted, Ends([high - from_high, low + from_low])));
        }
    }
    let margins = [0, TOP / 16, TOP / 4];
    let mut before = Vec::new();
    for (below, above) in margins.into_iter().flat_map(|below| margins.map(|above| (below, above))) {
        let inner = wanted.iter().copied().filter(|w| below < *w && *w < TOP - above);
        let (low, high) = bounds(inner).unwrap_or((0, 0));
        let ends =
            Ends([low / PARTS as i16, (high + PARTS as i16 - 1) / PARTS as i16].map(|code| code as u8));
        if best.error > 0 && !before.contains(&ends) {
            best = best.or(in_mode(wanted, ends));
            before.push(ends);
        }
    }
    best.ends
}

/// The best endpoints found from `begin`, in its mode.
fn in_mode(wanted: &Wanted, begin: Ends) -> Best<'_> {
    let mut best = Best { wanted, ends: begin, error: squared_error(wanted, &begin.levels()) };
    while best.error > 0 && fit(&mut best) {}
    while best.error > 0 && around(&mut best) {}
    best
}

/// Solves least squares for the indices of the best endpoints, and tries the codes around the solution. Returns whether
/// one of them was better.
fn fit(best: &mut Best<'_>) -> bool {
    let ends = best.ends;
    let whole = if ends.has_extremes() { 5 } else { 7 };
    // Sums over voxels: products of the weights of the two endpoints, and of each weight with the wanted level.
    let (mut aa, mut ab, mut bb, mut aw, mut bw) = (0_i64, 0_i64, 0_i64, 0_i64, 0_i64);
    for (index, wanted) in nearest(best.wanted, &ends.levels()).into_iter().zip(best.wanted) {
        let Some(b) = ends.share(index) else { continue };
        let (a, wanted) = (whole - b, i64::from(*wanted));
        aa += a * a;
        ab += a * b;
        bb += b * b;
        aw += a * wanted;
        bw += b * wanted;
    }
    let determinant = aa * bb - ab * ab;
    if determinant == 0 {
        return false;
    }
    let code = |numerator: i64| (whole * numerator).div_euclid(i64::from(PARTS) * determinant);
    let (first, second) = (code(bb * aw - ab * bw), code(aa * bw - ab * aw));
    let mut better = false;
    for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        better |= same_mode(ends, [first + a, second + b]).is_some_and(|ends| best.improves(ends));
    }
    better
}

/// Tries every pair of codes at most two away from the best.
fn around(best: &mut Best<'_>) -> bool {
    let centre = best.ends;
    let [first, second] = centre.0.map(i64::from);
    let mut better = false;
    for (a, b) in (-2..=2).flat_map(|a| (-2..=2).map(move |b| (a, b))) {
        better |= same_mode(centre, [first + a, second + b]).is_some_and(|ends| best.improves(ends));
    }
    better
}

/// These codes as endpoints, if they are valid and in the same mode.
fn same_mode(of: Ends, codes: [i64; 2]) -> Option<Ends> {
    let ends = Ends([u8::try_from(codes[0]).ok()?, u8::try_from(codes[1]).ok()?]);
    (ends.has_extremes() == of.has_extremes()).then_some(ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squared error of the best of all 65 536 pairs.
    fn least(wanted: &Wanted) -> u32 {
        let all = (0..=255).flat_map(|a| (0..=255).map(move |b| Ends([a, b])));
        all.map(|ends| squared_error(wanted, &ends.levels())).min().unwrap()
    }

    fn random(seed: u32) -> impl Iterator<Item = u32> {
        let mut state = seed.wrapping_mul(0x9e37_79b9) | 1;
        std::iter::repeat_with(move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        })
    }

    /// Edges, slopes, noise, narrow and wide, with and without the extremes.
    fn blocks() -> Vec<Wanted> {
        (0..96)
            .map(|n| {
                let mut next = random(n);
                let mut draw = |below: u32| (next.next().unwrap() % below) as i16;
                let (low, width) = (draw(7000), [40, 400, 1900][n as usize % 3]);
                std::array::from_fn(|i| match n / 3 % 5 {
                    0 => low + draw(width),
                    1 => low + (i as i16 % 4 * 3 + i as i16 / 4) * (width as i16 / 12) + draw(20),
                    2 if i % 4 < 2 => draw(30),
                    2 => low + draw(width),
                    3 if i < 6 => TOP - draw(2),
                    3 if i < 9 => 0,
                    3 => low + draw(width),
                    _ => (low + draw(width)) / 35 * 35,
                })
            })
            .collect()
    }

    #[test]
    fn the_search_finds_all_but_the_best_of_all_pairs() {
        let (mut searched, mut possible, mut of_range, mut optimal) = (0_u64, 0_u64, 0_u64, 0);
        let blocks = blocks();
        for wanted in &blocks {
            let range = ends_of_range(wanted);
            let found = squared_error(wanted, &search(wanted, range).levels());
            let best = least(wanted);
            assert!(found >= best);
            searched += u64::from(found);
            possible += u64::from(best);
            of_range += u64::from(squared_error(wanted, &range.levels()));
            optimal += u32::from(found == best);
        }
        println!("{optimal} of {} optimal; {searched} of {possible}, range {of_range}", blocks.len());
        assert!(searched * 100 <= possible * 103, "{searched} where {possible} is possible");
        assert!(of_range > searched * 5 / 4, "the range alone: {of_range}");
    }

    #[test]
    fn the_search_is_never_worse_than_the_range() {
        for wanted in blocks() {
            let range = ends_of_range(&wanted);
            let found = squared_error(&wanted, &search(&wanted, range).levels());
            assert!(found <= squared_error(&wanted, &range.levels()), "{wanted:?}");
        }
    }

    #[test]
    fn extremes_cost_no_endpoint() {
        let mut wanted = [100 * 35; TEXELS];
        (wanted[3], wanted[7], wanted[9]) = (0, TOP, 101 * 35);
        let ends = search(&wanted, ends_of_range(&wanted));
        assert!(ends.has_extremes());
        assert_eq!(squared_error(&wanted, &ends.levels()), 0);
    }

    #[test]
    fn a_constant_of_8_bits_is_exact() {
        for code in 0..=255_u8 {
            let wanted = [i16::from(code) * 35; TEXELS];
            for quality in [Quality::Range, Quality::Search] {
                let [first, second] = encode_block(&wanted, quality);
                assert_eq!((first, second), (u32::from(code) * 257, 0), "{quality:?}");
            }
        }
    }

    #[test]
    fn voxels_take_the_lowest_of_equally_near_levels() {
        // Between 10 and 0, which are both endpoints. The step between levels is 50 parts.
        let levels = Ends([10, 0]).levels();
        assert_eq!(nearest(&[325; TEXELS], &levels)[0], 0);
        assert_eq!(nearest(&[25; TEXELS], &levels)[0], 1);
        assert_eq!(nearest(&[275; TEXELS], &levels)[0], 2);
    }
}
