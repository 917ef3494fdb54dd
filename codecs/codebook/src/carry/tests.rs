//! Carried searches against searches by hand.

use super::*;
use crate::Quantiser;
use cvr_core::volume::ValueRange;
use proptest::prelude::*;

fn hashed(i: usize, seed: u32) -> f64 {
    let mut h = (i as u32 ^ seed).wrapping_mul(0x9e37_79b9);
    h = (h ^ (h >> 15)).wrapping_mul(0x85eb_ca6b);
    f64::from(h ^ (h >> 13)) / f64::from(u32::MAX)
}

fn by_hand(vectors: &Vectors, codebook: &Codebook) -> Vec<Nearest> {
    let nearest = |i| {
        let mut best = Nearest { index: 0, distance: f64::INFINITY };
        for k in 0..codebook.size() {
            let distance = squared(vectors.vector(i), codebook.codeword(k), None);
            if distance < best.distance {
                best = Nearest { index: k as u32, distance };
            }
        }
        best
    };
    (0..vectors.len()).map(nearest).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 80, failure_persistence: None, ..ProptestConfig::default() })]
    /// Codewords move, vanish, unite and appear at random, as they do in training. After every round each vector has
    /// the codeword of a brute-force search, and its bound holds. Few levels give many ties.
    #[test]
    fn rounds_carried_on_are_rounds_searched_anew(
        dimension in 1_usize..12,
        size in 2_usize..80,
        count in 1_usize..400,
        levels in prop_oneof![Just(3.0), Just(30.0), Just(1e6)],
        offset in prop_oneof![Just(0.0_f32), Just(-1e6), Just(1e30)],
        way in prop_oneof![Just(0.0), Just(0.02), Just(0.3)],
        guessed: bool,
        seed: u32,
    ) {
        let end = (f64::from(offset) * 1.5 + 256.0) as f32;
        let range = ValueRange { min: offset.min(end), max: offset.max(end) };
        let value = |i: usize, seed| {
            f64::from(range.min) + range.span() * (hashed(i, seed) * levels).floor() / levels
        };
        let quantiser = Quantiser::over(range, 8, false).unwrap();
        let words: Vec<f64> = (0..size * dimension).map(|i| value(i, seed)).collect();
        let mut codebook = Codebook::nearest_to(&words, dimension, quantiser);
        let rows: Vec<f32> = (0..count * dimension).map(|i| value(i, !seed) as f32).collect();
        let vectors = Vectors::of_rows(dimension, rows);
        let mut carried = if guessed {
            let any: Vec<u32> = (0..count).map(|i| (i % codebook.size()) as u32).collect();
            Carried::guessed(&vectors, &codebook, &any)
        } else {
            Carried::searched(&vectors, &codebook)
        };
        for round in 0..6_usize {
            let expected = by_hand(&vectors, &codebook);
            prop_assert_eq!(&carried.nearest, &expected, "round {}", round);
            for (i, known) in carried.others.iter().enumerate() {
                let others = (0..codebook.size()).filter(|k| *k != expected[i].index as usize);
                let distance = |k| squared(vectors.vector(i), codebook.codeword(k), None).sqrt();
                let least = others.map(distance).fold(f64::INFINITY, f64::min);
                prop_assert!(*known <= least, "round {round}: a bound of {known}, and {least} is there");
            }
            let cells = Cells::new(&carried.nearest, codebook.size());
            let mut next = codebook.kept(|_| false);
            let (mut steps, mut moves) = (Vec::new(), Vec::new());
            for k in 0..codebook.size() {
                let moved = !cells.members(k).is_empty() && hashed(k * 7 + round, seed) < 0.5;
                let shift = |(s, c): (usize, &u16)| {
                    let by = way * 255.0 * (hashed(k * 31 + s + 1000 * round, seed) - 0.5);
                    if moved { (f64::from(*c) + by).clamp(0.0, 255.0) as u16 } else { *c }
                };
                let codes: Vec<u16> = codebook.codes_of(k).iter().enumerate().map(shift).collect();
                steps.push(Step { index: next.size() as u32, moved: codes != codebook.codes_of(k) });
                if !cells.members(k).is_empty() {
                    next.push(&codes);
                    let place = next.size() - 1;
                    moves.push(squared(codebook.codeword(k), next.codeword(place), None).sqrt());
                }
            }
            if round % 2 == 0 {
                let codes: Vec<u16> = (0..dimension).map(|s| (hashed(s, seed ^ 5) * 255.0) as u16).collect();
                next.push(&codes);
                moves.push(f64::INFINITY);
            }
            codebook = next;
            carried.advance(&vectors, &cells, &codebook, &steps, &moves);
        }
    }
}
