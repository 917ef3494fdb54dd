//! The order of numbered files.

use std::cmp::Ordering;
use std::path::Path;

/// Orders names as people do: `step2` before `step10`. Where the numbers are equal, the bytes decide.
pub(in super::super) fn natural_order(a: &Path, b: &Path) -> Ordering {
    let (a, b) = (a.as_os_str().as_encoded_bytes(), b.as_os_str().as_encoded_bytes());
    compare(a, b).then_with(|| a.cmp(b))
}

fn compare(mut a: &[u8], mut b: &[u8]) -> Ordering {
    loop {
        match (a.first(), b.first()) {
            (Some(x), Some(y)) if x.is_ascii_digit() && y.is_ascii_digit() => {
                let (one, rest_a) = number(a);
                let (two, rest_b) = number(b);
                let order = one.len().cmp(&two.len()).then_with(|| one.cmp(two));
                if order != Ordering::Equal {
                    return order;
                }
                (a, b) = (rest_a, rest_b);
            }
            (Some(x), Some(y)) if x == y => (a, b) = (&a[1..], &b[1..]),
            (x, y) => return x.cmp(&y),
        }
    }
}

/// The digits in front, without leading zeros, and the rest.
fn number(text: &[u8]) -> (&[u8], &[u8]) {
    let end = text.iter().position(|c| !c.is_ascii_digit()).unwrap_or(text.len());
    let (digits, rest) = text.split_at(end);
    let zeros = digits.iter().position(|c| *c != b'0').unwrap_or(digits.len());
    (&digits[zeros..], rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_count_and_the_rest_is_bytes() {
        let sorted = ["a/2.png", "a/10.png", "s1", "s01", "s2t9", "s2t10", "s02x", "s10", "s10a", "t"];
        for (i, a) in sorted.iter().enumerate() {
            for (j, b) in sorted.iter().enumerate() {
                let order = natural_order(Path::new(a), Path::new(b));
                let expected =
                    if (*a, *b) == ("s1", "s01") || (*b, *a) == ("s1", "s01") { a.cmp(b) } else { i.cmp(&j) };
                assert_eq!(order, expected, "{a} {b}");
            }
        }
        let huge = format!("{}1", "9".repeat(40));
        assert_eq!(natural_order(Path::new(&huge), Path::new("2")), Ordering::Greater);
    }
}
