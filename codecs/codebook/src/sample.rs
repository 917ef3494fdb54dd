//! Draws the blocks of a training set.

use std::collections::HashSet;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng as _, SeedableRng as _};

/// Name of the generator, for the record: PCG XSL RR 128/64 (O'Neill 2014), seeded by `seed_from_u64`.
pub const GENERATOR: &str = "pcg64";

/// `count` of the numbers below `all`, all equally likely, in ascending order. All numbers if there are no more than
/// `count`. R. W. Floyd's algorithm (Bentley and Floyd 1987): it draws and stores only `count` numbers.
#[must_use]
pub fn choose(all: u64, count: u64, seed: u64) -> Vec<u64> {
    if count >= all {
        return (0..all).collect();
    }
    let mut generator = Pcg64::seed_from_u64(seed);
    let mut chosen = HashSet::with_capacity(count as usize);
    for last in all - count..all {
        // Uniform in 0..=last, with a bias below last / 2^64.
        let drawn = ((u128::from(generator.next_u64()) * (u128::from(last) + 1)) >> 64) as u64;
        if !chosen.insert(drawn) {
            chosen.insert(last);
        }
    }
    let mut chosen: Vec<u64> = chosen.into_iter().collect();
    chosen.sort_unstable();
    chosen
}

/// How many to draw from each stratum, `count` in all: half in proportion to the strata, half evenly, so that a rare
/// stratum is not missed. No stratum gives more than it holds. If `count` is at least their sum, all of each.
#[must_use]
pub fn allot(strata: &[u64], count: u64) -> Vec<u64> {
    let all: u64 = strata.iter().sum();
    let count = count.min(all);
    let share = |size: u64| (u128::from(count) * u128::from(size) / (2 * u128::from(all.max(1)))) as u64;
    let mut allotted: Vec<u64> = strata.iter().map(|size| share(*size)).collect();
    let mut left = count - allotted.iter().sum::<u64>();
    while left > 0 {
        let open = strata.iter().zip(&allotted).filter(|(size, a)| a < size).count() as u64;
        // The remainder goes to the last strata, one each.
        let (each, mut more) = (left / open, left % open);
        for (size, a) in strata.iter().zip(&mut allotted).rev() {
            if *a == *size {
                continue;
            }
            let given = (each + u64::from(more > 0)).min(size - *a);
            more = more.saturating_sub(1);
            *a += given;
            left -= given;
        }
    }
    allotted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_choice_is_that_of_the_seed() {
        assert_eq!(choose(1000, 8, 1), choose(1000, 8, 1));
        assert_ne!(choose(1000, 8, 1), choose(1000, 8, 2));
        assert_eq!(choose(5, 5, 3), [0, 1, 2, 3, 4]);
        assert_eq!(choose(5, 99, 3), [0, 1, 2, 3, 4]);
        // Stored values detect a change of generator or algorithm, which would change every stream.
        assert_eq!(choose(1 << 30, 4, 1), CHOSEN);
    }

    const CHOSEN: [u64; 4] = [18_574_310, 122_301_029, 901_807_471, 1_055_505_265];

    #[test]
    fn rare_strata_are_drawn_from() {
        assert_eq!(allot(&[9000, 900, 100], 600), [371, 129, 100]);
        for (strata, count) in
            [(vec![5, 0, 7], 12), (vec![5, 0, 7], 99), (vec![1 << 40, 3, 1], 1000), (vec![8], 3)]
        {
            let allotted = allot(&strata, count);
            assert_eq!(allotted.iter().sum::<u64>(), count.min(strata.iter().sum()), "{strata:?} {count}");
            assert!(allotted.iter().zip(&strata).all(|(a, s)| a <= s), "{allotted:?} of {strata:?}");
        }
        assert_eq!(allot(&[1 << 40, 3, 1], 1000)[1..], [3, 1]);
    }

    #[test]
    fn every_number_is_as_likely_as_any_other() {
        let mut counts = [0_u32; 20];
        for seed in 0..4000 {
            let chosen = choose(20, 5, seed);
            assert!(chosen.len() == 5 && chosen.is_sorted_by(|a, b| a < b));
            chosen.iter().for_each(|i| counts[*i as usize] += 1);
        }
        // 1000 each; the standard deviation is 27.
        assert!(counts.iter().all(|c| (860..1140).contains(c)), "{counts:?}");
    }
}
