//! Groups written and read: every block comes back, whatever it keeps, and what leads outside is refused.

use proptest::prelude::*;

use crate::{Codes, Escape, Groups, HEAD_WORDS, Limits, Scale, Tally, Writer, check, mean_width, part_value};

/// What a block keeps: its mean, codes, and its escape's parts.
#[derive(Clone, Debug)]
struct Kept {
    mean: u32,
    codes: Vec<u16>,
    escape: Vec<Escape>,
}

const CODE_BITS: u32 = 5;
const CODEWORDS: [u32; 63] = [32; 63];

fn escape() -> impl Strategy<Value = Escape> {
    (1_u32..=16, Escape::LOWS[0]..=Escape::LOWS[1], 0_u32..8, any::<u32>()).prop_map(
        |(bits, low, fraction, seed)| {
            let number = |i: usize| ((i as u32 ^ seed).wrapping_mul(0x9e37_79b9) >> (32 - bits)) as u16;
            let step = Scale::of_byte((seed % (Escape::most_exponent(bits) + 1)) | (fraction << 5));
            Escape { bits, low, step, numbers: std::array::from_fn(number) }
        },
    )
}

/// Blocks of a group that keep much or nothing, so that masks, planes of one word and of two, and empty groups all come up.
fn blocks(parts: usize) -> impl Strategy<Value = Vec<Kept>> {
    let block = move |busy: f64, escaped: f64, most: u32| {
        let codes = prop::collection::vec(0_u16..32, 0..=most as usize);
        let escape = prop::collection::vec(escape(), parts);
        (prop::bool::weighted(busy), prop::bool::weighted(escaped), 0_u32..300, codes, escape).prop_map(
            |(busy, escaped, mean, codes, escape)| Kept {
                mean: if busy { 700 + mean } else { 700 },
                codes: if busy { codes } else { Vec::new() },
                // All parts have the bits of the first.
                escape: if escaped { alike(escape) } else { Vec::new() },
            },
        )
    };
    (0.0..1.0_f64, prop::sample::select(vec![0.0, 0.03, 0.5, 1.0]), 0_u32..=63, 1_usize..=64).prop_flat_map(
        move |(busy, escaped, most, count)| prop::collection::vec(block(busy * busy, escaped, most), count),
    )
}

/// Numbers cut to the bits of the first part.
fn alike(mut parts: Vec<Escape>) -> Vec<Escape> {
    let bits = parts[0].bits;
    for part in &mut parts {
        part.numbers = part.numbers.map(|n| n & ((1_u32 << bits) - 1) as u16);
        part.bits = bits;
        part.step =
            Scale::of_byte((part.step.byte() & 0xe0) | part.step.exponent().min(Escape::most_exponent(bits)));
    }
    parts
}

/// Heads and words of some groups, and what they come to.
fn written(groups: &[Vec<Kept>], parts: u32) -> (Vec<u32>, Vec<u32>) {
    let mut writer = Writer::new(parts);
    for group in groups {
        let words: Vec<Vec<u32>> = group.iter().map(|kept| words(&kept.escape)).collect();
        let block = |(kept, escape)| {
            let Kept { mean, codes, .. }: &Kept = kept;
            Codes { mean: *mean, codes, escape }
        };
        let blocks: Vec<Codes<'_>> = group.iter().zip(words.iter().map(|w| &w[..])).map(block).collect();
        let means = mean_width(group.iter().map(|kept| kept.mean));
        let mut tally = Tally::default();
        for kept in group {
            let escape = kept.escape.first().map(|part| part.bits);
            tally.add(kept.mean == means.0, kept.codes.len() as u32, escape);
        }
        let before = writer.len();
        writer.push(&blocks, means, CODE_BITS).unwrap();
        assert_eq!((writer.len() - before) as u32, tally.words(means.1, CODE_BITS, parts), "{tally:?}");
    }
    writer.finish()
}

fn words(parts: &[Escape]) -> Vec<u32> {
    let mut words = Vec::new();
    parts.iter().for_each(|part| part.write(&mut words));
    words
}

fn limits(blocks: usize) -> Limits<'static> {
    Limits { blocks: blocks as u32, code_bits: CODE_BITS, codewords: &CODEWORDS, greatest_mean: 1500 }
}

fn reads_back(groups: &[Vec<Kept>], parts: u32) -> Result<(), TestCaseError> {
    let (heads, words) = written(groups, parts);
    prop_assert_eq!(heads.len(), groups.len() * HEAD_WORDS as usize);
    let frame = Groups { heads: &heads, words: &words, parts };
    for (g, group) in groups.iter().enumerate() {
        prop_assert_eq!(check(&frame, g, &limits(group.len())), Ok(()));
        for (n, kept) in group.iter().enumerate() {
            let block = frame.block(g, n as u32, group.len() as u32, CODE_BITS);
            prop_assert_eq!(block.mean, kept.mean);
            let codes: Vec<u16> = (0..block.count).map(|i| frame.code(&block, i, CODE_BITS) as u16).collect();
            prop_assert_eq!(&codes, &kept.codes);
            prop_assert_eq!(block.rest_bits, kept.escape.first().map_or(0, |part| part.bits));
            for (p, part) in kept.escape.iter().enumerate() {
                let first = block.rest + p as u32 * crate::part_words(part.bits);
                for (place, number) in part.numbers.iter().enumerate() {
                    let value = part.low + part.step.units() as i32 * i32::from(*number);
                    prop_assert_eq!(part_value(&words, first, part.bits, place), value);
                }
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn groups_come_back(groups in prop::collection::vec(blocks(1), 1..4)) {
        reads_back(&groups, 1)?;
    }

    #[test]
    fn groups_of_three_parts_come_back(groups in prop::collection::vec(blocks(3), 1..3)) {
        reads_back(&groups, 3)?;
    }

    /// Whatever a hostile stream holds: it is refused, or everything that it leads to lies inside.
    #[test]
    fn what_is_not_refused_leads_nowhere_outside(
        group in blocks(1),
        changes in prop::collection::vec((any::<u32>(), 0_u32..32), 1..4),
    ) {
        let count = group.len() as u32;
        let (mut heads, mut words) = written(&[group], 1);
        for (place, bit) in changes {
            // Half of the changes hit the head.
            let i = (place >> 1) as usize;
            if place & 1 == 0 {
                heads[i % HEAD_WORDS as usize] ^= 1 << bit;
            } else {
                let length = words.len();
                words[i % length] ^= 1 << bit;
            }
        }
        let frame = Groups { heads: &heads, words: &words, parts: 1 };
        if check(&frame, 0, &limits(count as usize)).is_ok() {
            for n in 0..count {
                let block = frame.block(0, n, count, CODE_BITS);
                prop_assert!(block.mean <= 1500 && block.count <= 63);
                for i in 0..block.count {
                    prop_assert!(frame.code(&block, i, CODE_BITS) < 32);
                }
                if block.rest_bits > 0 {
                    let range = crate::part_range(&words, block.rest, block.rest_bits);
                    for place in 0..64 {
                        let value = part_value(&words, block.rest, block.rest_bits, place);
                        prop_assert!((range.0..=range.1).contains(&value));
                    }
                }
            }
        }
    }
}

fn plain(mean: u32) -> Kept {
    Kept { mean, codes: Vec::new(), escape: Vec::new() }
}

/// A group of bare blocks has no words, and one busy block among 64 costs a mask beside its own.
#[test]
fn a_bare_block_costs_at_most_a_bit() {
    let mut group: Vec<Kept> = (0..64).map(|_| plain(700)).collect();
    let words = |group: &[Kept]| written(&[group.to_vec()], 1).1.len() - 1;
    assert_eq!(words(&group), 0);
    group[17] = Kept { codes: vec![1, 2, 3], ..plain(900) };
    // The mask, two planes of counts, eight bits of a mean and three codes.
    assert_eq!(words(&group), 2 + 2 + 1);
    // All have records: there is no mask.
    let all: Vec<Kept> = (0..64).map(|n| Kept { codes: vec![1], ..plain(700 + n) }).collect();
    assert_eq!(words(&all), 2 + (64 * 6 + 64 * 5) / 32);
}

/// Each check refuses what it is for.
#[test]
fn what_leads_outside_is_refused() {
    let part = Escape { bits: 3, low: -5, step: Scale::ONE, numbers: [6; 64] };
    let mut group: Vec<Kept> = (0..64).map(|n| plain(700 + n)).collect();
    group[0] = Kept { mean: 700, codes: vec![31; 4], escape: vec![part] };
    let (heads, words) = written(&[group], 1);
    let said = |heads: &[u32], words: &[u32], limits: &Limits<'_>| {
        check(&Groups { heads, words, parts: 1 }, 0, limits).unwrap_err()
    };
    assert_eq!(check(&Groups { heads: &heads, words: &words, parts: 1 }, 0, &limits(64)), Ok(()));
    let head = |start: u32, form: u32| [start, form];
    let form = heads[1];
    for (heads, problem) in [
        (head(heads[0] - 1, form), "an escape of 3 bits ends at word 6"),
        (head(words.len() as u32, form), "planes end"),
        (head(u32::MAX, form), "planes end"),
        (head(heads[0], form | 31 << 16), "means of 31 bits"),
        (head(heads[0], form | 0xffff), "a mean of code 65535"),
    ] {
        let found = said(&heads, &words, &limits(64));
        assert!(found.contains(problem), "{found}: {problem}");
    }
    let short = said(&heads, &words[..words.len() - 3], &limits(64));
    assert!(short.contains("end") || short.contains("keeps"), "{short}");
    let few = Limits { codewords: &[32; 3], ..limits(64) };
    assert_eq!(said(&heads, &words, &few), "a block keeps 4 codes");
    let small = Limits { codewords: &[31; 63], ..limits(64) };
    assert_eq!(said(&heads, &words, &small), "a block names a codeword of 31");
    let mut steep = words.clone();
    steep[0] |= 31;
    assert_eq!(said(&heads, &steep, &limits(64)), "the step of an escape of 3 bits is too large");
    let mut named: Vec<Kept> = (0..20).map(|_| plain(700)).collect();
    named[3] = Kept { codes: vec![1], ..plain(790) };
    let (heads, mut words) = written(&[named], 1);
    words[0] |= 1 << 20;
    assert_eq!(said(&heads, &words, &limits(20)), "a record of a block beyond the 20 of the group");
}
