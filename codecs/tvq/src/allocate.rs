//! Who gets how many codevectors.

/// Shares of `size` codevectors for classes such that the mean distortion per codevector is about equal in all of them
/// (Ramamurthi and Gersho 1986). At high resolution the distortion of a class of energy `E` in `d` dimensions falls as
/// `E · n^(−2/d)`, so that `E · n^(−2/d) / n` is equal where `n ∝ E^(d / (d + 2))`. A class with members gets one at
/// least, as long as there are any, and none gets more than it has members.
#[must_use]
pub fn shares(energies: &[f64], members: &[usize], size: usize, dimension: usize) -> Vec<usize> {
    let exponent = dimension as f64 / (dimension as f64 + 2.0);
    let mut shares = vec![0; energies.len()];
    // Those of most energy first, where not every class can have one.
    let mut order: Vec<usize> =
        (0..energies.len()).filter(|c| members[*c] > 0 && energies[*c] > 0.0).collect();
    order.sort_by(|a, b| energies[*b].total_cmp(&energies[*a]).then(a.cmp(b)));
    let mut left = size;
    for &class in order.iter().take(size) {
        shares[class] = 1;
        left -= 1;
    }
    // One by one to the class whose codevectors have most to carry: that keeps the shares in proportion.
    while left > 0 {
        let load = |class: &usize| energies[*class].powf(exponent) / (shares[*class] as f64 + 0.5);
        let open = order.iter().filter(|class| shares[**class] < members[**class]);
        let Some(&next) = open.max_by(|a, b| load(a).total_cmp(&load(b)).then(b.cmp(a))) else { break };
        // In larger steps as long as that makes no difference of more than a hundredth.
        let step = (shares[next] / 100).clamp(1, left).min(members[next] - shares[next]);
        shares[next] += step;
        left -= step;
    }
    shares
}

/// One choice for a quantiser.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Choice {
    /// Bits that it takes in all.
    pub bits: f64,
    /// What it leaves: a distortion, or the logarithm of the part of it that is left.
    pub left: f64,
}

/// One choice for each quantiser such that the sum of what they leave is least and that of their bits at most `budget`
/// (Shoham and Gersho 1988): every quantiser takes the choice of least `left + λ · bits`, λ as small as the budget
/// allows; then single choices improve as long as bits remain. Each list begins with the choice of fewest bits, which is
/// taken where even that exceeds the budget.
#[must_use]
pub fn allocate(curves: &[Vec<Choice>], budget: f64) -> Vec<usize> {
    let at = |lambda: f64| -> Vec<usize> {
        let cost = |c: &Choice| c.left + lambda * c.bits;
        let best = |curve: &Vec<Choice>| {
            (0..curve.len()).min_by(|a, b| cost(&curve[*a]).total_cmp(&cost(&curve[*b]))).unwrap_or(0)
        };
        curves.iter().map(best).collect()
    };
    let bits = |chosen: &[usize]| chosen.iter().zip(curves).map(|(i, c)| c[*i].bits).sum::<f64>();
    let (mut low, mut high) = (0.0, 1.0);
    if bits(&at(low)) <= budget {
        return at(low);
    }
    while bits(&at(high)) > budget {
        high *= 4.0;
        if high > 1e60 {
            return vec![0; curves.len()];
        }
    }
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if bits(&at(middle)) <= budget { high = middle } else { low = middle }
    }
    let mut chosen = at(high);
    // Between the corners of the convex hull.
    loop {
        let spare = budget - bits(&chosen);
        let mut best: Option<(usize, usize, f64)> = None;
        for (q, curve) in curves.iter().enumerate() {
            let now = curve[chosen[q]];
            for (i, c) in curve.iter().enumerate() {
                let gain = now.left - c.left;
                if c.bits - now.bits <= spare && gain > 0.0 && best.is_none_or(|b| gain > b.2) {
                    best = Some((q, i, gain));
                }
            }
        }
        let Some((q, i, _)) = best else { return chosen };
        chosen[q] = i;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_follow_the_energy_and_add_up() {
        let shares = shares(&[0.0, 8.0, 1.0, 1e-9], &[5, 1000, 1000, 3], 100, 64);
        assert_eq!(shares.iter().sum::<usize>(), 100);
        assert_eq!((shares[0], shares[3]), (0, 1));
        assert!((85..91).contains(&shares[1]), "{shares:?}");
    }

    #[test]
    fn nobody_gets_more_than_there_are_members() {
        assert_eq!(shares(&[3.0, 1.0], &[2, 50], 20, 7), [2, 18]);
        assert_eq!(shares(&[3.0, 1.0], &[2, 3], 20, 7), [2, 3]);
        assert_eq!(shares(&[1.0, 3.0], &[2, 3], 1, 7), [0, 1]);
        assert_eq!(shares(&[1.0, 3.0], &[2, 3], 0, 7), [0, 0]);
    }

    /// Against trying all pairs.
    #[test]
    fn the_allocation_is_the_best_on_convex_curves() {
        let curve = |energy: f64| -> Vec<Choice> {
            (0..10).map(|b| Choice { bits: f64::from(b), left: energy * 0.6_f64.powi(b) }).collect()
        };
        let curves = [curve(10.0), curve(3.0)];
        for budget in 0..18 {
            let budget = f64::from(budget);
            let chosen = allocate(&curves, budget);
            let left = |c: &[usize]| curves[0][c[0]].left + curves[1][c[1]].left;
            let pairs = (0..10_usize).flat_map(|a| (0..10_usize).map(move |b| [a, b]));
            let best =
                pairs.filter(|p| (p[0] + p[1]) as f64 <= budget).map(|p| left(&p)).fold(99.0, f64::min);
            assert!(left(&chosen) <= best * 1.001, "{budget}: {chosen:?} leaves {} > {best}", left(&chosen));
        }
    }

    #[test]
    fn too_small_a_budget_gets_the_fewest_bits() {
        let curve = vec![Choice { bits: 5.0, left: 1.0 }, Choice { bits: 9.0, left: 0.5 }];
        assert_eq!(allocate(&[curve], 1.0), [0]);
    }
}
