//! Distribution of codevectors over classes.

/// Shares of `size` codevectors, so that the mean distortion per codevector is about equal in all classes (Ramamurthi
/// and Gersho 1986). At high resolution the distortion of a class of energy `E` in `d` dimensions falls as `E ·
/// n^(−2/d)`. So `E · n^(−2/d) / n` is equal if `n ∝ E^(d / (d + 2))`. A class with members gets at least one while
/// there are any. No class gets more than its members.
#[must_use]
pub fn shares(energies: &[f64], members: &[usize], size: usize, dimension: usize) -> Vec<usize> {
    let exponent = dimension as f64 / (dimension as f64 + 2.0);
    let mut shares = vec![0; energies.len()];
    // Classes with the most energy first, if there are too few codevectors.
    let mut order: Vec<usize> =
        (0..energies.len()).filter(|c| members[*c] > 0 && energies[*c] > 0.0).collect();
    order.sort_by(|a, b| energies[*b].total_cmp(&energies[*a]).then(a.cmp(b)));
    let mut left = size;
    for &class in order.iter().take(size) {
        shares[class] = 1;
        left -= 1;
    }
    // One by one to the class with the most distortion per codevector. This keeps the shares in proportion.
    while left > 0 {
        let load = |class: &usize| energies[*class].powf(exponent) / (shares[*class] as f64 + 0.5);
        let open = order.iter().filter(|class| shares[**class] < members[**class]);
        let Some(&next) = open.max_by(|a, b| load(a).total_cmp(&load(b)).then(b.cmp(a))) else { break };
        // In larger steps while the difference is below a hundredth.
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
