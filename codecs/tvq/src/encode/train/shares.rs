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
}
