//! The order of numbered files.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

/// Sorts names as people do: `step2` before `step10`, `t0.05` before `t0.1`. Where the numbers are equal, the bytes
/// decide.
///
/// A number is a run of digits. One with a dot between two runs is a decimal (`0.25`); with two dots or more
/// (`1.10.2`, `2024.01.15`) each run is a number of its own. A minus at the beginning of a name, or behind `_`, `=`, `(`
/// or a space, is a sign; `e-05` and `e+05` behind digits are an exponent. The extension is left out: what stands behind
/// the last dot and has a letter.
///
/// In `v1.8`, `v1.9`, `v1.10` the dot separates counters. All names together distinguish them from decimals:
/// their last runs have several lengths, one ends in 0 where others are shorter, and none begins with one.
pub(in super::super) fn sort_naturally(files: &mut [PathBuf]) {
    let reading = Dots::of(files);
    files.sort_by_cached_key(|file| Key::new(file, reading));
}

/// Meaning of a single dot between digits.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
enum Dots {
    Decimal,
    Separator,
}

impl Dots {
    /// The meaning of dots in all of these names.
    fn of(files: &[PathBuf]) -> Self {
        let mut shortest = usize::MAX;
        let mut longest_round = 0;
        for name in files.iter().flat_map(|f| components(f)) {
            for chain in chains(&name) {
                let [_, fraction] = chain.runs[..] else { continue };
                let is_padded = fraction.len() > 1 && fraction[0] == b'0';
                if is_padded || chain.exponent.is_some() {
                    return Self::Decimal;
                }
                shortest = shortest.min(fraction.len());
                if fraction.len() > 1 && fraction.ends_with(b"0") {
                    longest_round = longest_round.max(fraction.len());
                }
            }
        }
        if longest_round > shortest { Self::Separator } else { Self::Decimal }
    }
}

/// Digits between dots, as written in a name.
struct Chain<'a> {
    /// Where it begins and ends, sign and exponent included.
    span: std::ops::Range<usize>,
    is_negative: bool,
    runs: Vec<&'a [u8]>,
    exponent: Option<i64>,
}

fn digits(text: &[u8]) -> usize {
    text.iter().position(|c| !c.is_ascii_digit()).unwrap_or(text.len())
}

/// All chains of a name, in order.
fn chains(name: &[u8]) -> Vec<Chain<'_>> {
    let mut chains = Vec::new();
    let mut at = 0;
    while at < name.len() {
        let length = digits(&name[at..]);
        if length == 0 {
            at += 1;
            continue;
        }
        let mut runs = vec![&name[at..at + length]];
        let mut end = at + length;
        while name.get(end) == Some(&b'.') {
            let length = digits(&name[end + 1..]);
            if length == 0 {
                break;
            }
            runs.push(&name[end + 1..end + 1 + length]);
            end += 1 + length;
        }
        let is_signed =
            at > 0 && name[at - 1] == b'-' && (at == 1 || matches!(name[at - 2], b'_' | b'=' | b'(' | b' '));
        let exponent = exponent(&name[end..]);
        let length = exponent.map_or(0, |(_, length)| length);
        chains.push(Chain {
            span: at - usize::from(is_signed)..end + length,
            is_negative: is_signed,
            runs,
            exponent: exponent.map(|(exponent, _)| exponent),
        });
        at = end + length;
    }
    chains
}

/// The exponent `e-05` and its length. Without a sign, the letter belongs to the name.
fn exponent(text: &[u8]) -> Option<(i64, usize)> {
    let [b'e' | b'E', sign @ (b'+' | b'-'), rest @ ..] = text else { return None };
    let length = digits(rest);
    // Six digits are more than any number has, and cannot overflow.
    let magnitude: i64 =
        std::str::from_utf8(rest.get(..length)?).ok().filter(|d| d.len() <= 6)?.parse().ok()?;
    Some((if *sign == b'-' { -magnitude } else { magnitude }, 2 + length))
}

/// The parts of a path, the last without its extension.
fn components(path: &Path) -> Vec<Vec<u8>> {
    let mut names: Vec<Vec<u8>> =
        path.components().map(|c| c.as_os_str().as_encoded_bytes().to_vec()).collect();
    if let Some(last) = names.last_mut()
        && let Some(dot) = last.iter().rposition(|c| *c == b'.').filter(|dot| *dot > 0)
        && last[dot..].iter().any(u8::is_ascii_alphabetic)
    {
        last.truncate(dot);
    }
    names
}

/// Sort key of a file.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    names: Vec<Vec<Token>>,
    path: PathBuf,
}

impl Key {
    fn new(path: &Path, dots: Dots) -> Self {
        let names = components(path).iter().map(|name| tokens(name, dots)).collect();
        Self { names, path: path.to_owned() }
    }
}

/// A part of a name.
#[derive(PartialEq, Eq)]
enum Token {
    Byte(u8),
    Number(Number),
}

impl Token {
    /// Numbers stand among other characters where their first one does.
    const fn first(&self) -> u8 {
        match self {
            Self::Byte(byte) => *byte,
            Self::Number(Number { is_negative: true, .. }) => b'-',
            Self::Number(_) => b'0',
        }
    }
}

impl Ord for Token {
    fn cmp(&self, other: &Self) -> Ordering {
        match (self, other) {
            (Self::Number(a), Self::Number(b)) => a.cmp(b),
            // A minus that is not a sign comes before one that is.
            (a, b) => a
                .first()
                .cmp(&b.first())
                .then_with(|| matches!(a, Self::Number(_)).cmp(&matches!(b, Self::Number(_)))),
        }
    }
}

impl PartialOrd for Token {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

fn tokens(name: &[u8], dots: Dots) -> Vec<Token> {
    let mut tokens = Vec::new();
    let mut at = 0;
    for chain in chains(name) {
        tokens.extend(name[at..chain.span.start].iter().copied().map(Token::Byte));
        at = chain.span.end;
        let is_decimal = chain.runs.len() == 2 && dots == Dots::Decimal;
        if let [whole, fraction] = chain.runs[..]
            && is_decimal
        {
            tokens.push(Token::Number(Number::new(chain.is_negative, whole, fraction, chain.exponent)));
            continue;
        }
        let last = chain.runs.len() - 1;
        for (i, run) in chain.runs.iter().enumerate() {
            if i > 0 {
                tokens.push(Token::Byte(b'.'));
            }
            let exponent = chain.exponent.filter(|_| i == last);
            tokens.push(Token::Number(Number::new(chain.is_negative && i == 0, run, &[], exponent)));
        }
    }
    tokens.extend(name[at..].iter().copied().map(Token::Byte));
    tokens
}

/// A decimal number of any length: 0.`digits` × 10^`exponent`, without zeros in front and behind.
#[derive(PartialEq, Eq)]
struct Number {
    is_negative: bool,
    digits: Vec<u8>,
    exponent: i64,
}

impl Number {
    fn new(is_negative: bool, whole: &[u8], fraction: &[u8], exponent: Option<i64>) -> Self {
        let all = [whole, fraction].concat();
        let zeros = all.iter().position(|c| *c != b'0').unwrap_or(all.len());
        let end = all.iter().rposition(|c| *c != b'0').map_or(zeros, |last| last + 1);
        let digits = all[zeros..end].to_vec();
        if digits.is_empty() {
            return Self { is_negative: false, digits, exponent: i64::MIN };
        }
        let point = whole.len() as i64 - zeros as i64;
        Self { is_negative, digits, exponent: point + exponent.unwrap_or(0) }
    }
}

impl Ord for Number {
    fn cmp(&self, other: &Self) -> Ordering {
        let magnitude = || self.exponent.cmp(&other.exponent).then_with(|| self.digits.cmp(&other.digits));
        match (self.is_negative, other.is_negative) {
            (false, false) => magnitude(),
            (true, true) => magnitude().reverse(),
            (negative, _) => {
                if negative {
                    Ordering::Less
                } else {
                    Ordering::Greater
                }
            }
        }
    }
}

impl PartialOrd for Number {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Sorts these names from the reversed order, and says what came.
    fn sorted(names: &[&str]) -> Vec<String> {
        let mut files: Vec<PathBuf> = names.iter().rev().map(PathBuf::from).collect();
        sort_naturally(&mut files);
        files.iter().map(|f| f.to_str().unwrap().to_owned()).collect()
    }

    #[test]
    fn names_come_in_the_order_of_their_numbers() {
        let huge = format!("{}1", "9".repeat(40));
        for names in [
            &["a/2.png", "a/10.png", "s1", "s2t9", "s2t10", "s02x", "s10", "s10a", "t"][..],
            &[
                "T_0.raw",
                "T_0.05.raw",
                "T_0.1.raw",
                "T_0.25.raw",
                "T_0.5.raw",
                "T_1.raw",
                "T_1.5.raw",
                "T_10.raw",
            ],
            &["0.00", "0.05", "0.10", "0.25", "1.00", "10.00"],
            &["0.0.vti", "0.5.vti", "1.0.vti", "1.5.vti", "10.0.vti"],
            &["t1e-05.npy", "t0.0001.npy", "t0.001.npy", "t1.npy", "t2.5e+03.npy", "t1e+05.npy"],
            &["T_-10.5.raw", "T_-10.raw", "T_-0.5.raw", "T_0.raw", "T_5.raw"],
            &["-2.raw", "-1.raw", "0.raw", "1.raw"],
            &["frame.9.raw", "frame.10.raw", "frame.100.raw"],
            &["a.1.raw", "a.2.raw", "a.10.raw"],
            &["v1.8", "v1.9", "v1.10", "v1.11", "v2.0"],
            &["v1.9.1.raw", "v1.10.0.raw", "v1.10.2.raw"],
            &["2023.12.31.tif", "2024.01.15.tif", "2024.2.3.tif", "2024.10.1.tif"],
            &["2023-12-31.tif", "2024-01-15.tif", "2024-02-03.tif"],
            &["scan-1.tif", "scan-2.tif", "scan-10.tif"],
            &["s.5.3d", "s.5.25.3d", "s.10.3d"],
            &["run2/step9.raw", "run2/step10.raw", "run10/step1.raw"],
            &["t.raw", "t-1.raw"],
            &["2", &huge],
        ] {
            assert_eq!(sorted(names), names);
        }
        assert_eq!(sorted(&["s01", "s1"]), ["s01", "s1"], "equal numbers: the bytes decide");
    }

    proptest! {
        /// Numbers of any form are ordered by value.
        #[test]
        fn numbers_are_sorted_by_value(
            mut values in prop::collection::vec((any::<bool>(), 0_u32..2000, 0_u32..1000), 2..9),
        ) {
            let value = |(negative, whole, thousandths): &(bool, u32, u32)| {
                let magnitude = i64::from(*whole) * 1000 + i64::from(*thousandths);
                if *negative { -magnitude } else { magnitude }
            };
            values.sort_by_key(value);
            values.dedup_by_key(|v| value(v));
            let names: Vec<String> = values.iter().map(|(negative, whole, thousandths)| {
                let fraction = format!("{thousandths:03}");
                let fraction = fraction.trim_end_matches('0');
                let dot = if fraction.is_empty() { "" } else { "." };
                let sign = if *negative && (*whole, *thousandths) != (0, 0) { "-" } else { "" };
                format!("t_{sign}{whole}{dot}{fraction}.raw")
            }).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            prop_assert_eq!(sorted(&names), names);
        }

        /// The order is one: sorting any permutation gives the same.
        #[test]
        fn the_order_is_total(
            mut names in prop::collection::vec("[a._0-9-]{1,8}", 2..12),
            turn in any::<prop::sample::Index>(),
        ) {
            let ordered = sorted(&names.iter().map(String::as_str).collect::<Vec<_>>());
            let turn = turn.index(names.len());
            names.rotate_left(turn);
            prop_assert_eq!(ordered, sorted(&names.iter().map(String::as_str).collect::<Vec<_>>()));
        }
    }
}
