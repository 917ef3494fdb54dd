//! Squared distances in double precision, summed in a fixed order. They decide if single precision is not enough.

/// `Σ (a − b)²` over the components in `mask`, or over all without a mask.
#[inline(always)]
pub fn squared(a: &[f32], b: &[f32], mask: Option<&[bool]>) -> f64 {
    let term = |a: f32, b: f32| {
        let difference = f64::from(a) - f64::from(b);
        difference * difference
    };
    match mask {
        Some(mask) => {
            a.iter().zip(b).zip(mask).filter(|(_, inside)| **inside).map(|((a, b), _)| term(*a, *b)).sum()
        }
        None => {
            // Four sums, so that one addition does not wait for the other.
            let mut sums = [0.0; 4];
            let (fours, others) = (a.chunks_exact(4).zip(b.chunks_exact(4)), a.len() / 4 * 4);
            for (a, b) in fours {
                for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
                    *sum += term(*a, *b);
                }
            }
            let rest: f64 = a[others..].iter().zip(&b[others..]).map(|(a, b)| term(*a, *b)).sum();
            (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_mask_lets_through_counts() {
        let (a, b) = ([1.0, 2.0, 3.0, 4.0, 5.0], [0.0, 4.0, 0.0, 4.0, 8.0]);
        assert_eq!(squared(&a, &b, None), 1.0 + 4.0 + 9.0 + 9.0);
        assert_eq!(squared(&a, &b, Some(&[true; 5])), 23.0);
        assert_eq!(squared(&a, &b, Some(&[false, true, false, true, true])), 13.0);
    }
}
