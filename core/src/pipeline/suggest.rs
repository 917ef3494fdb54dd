//! "Did you mean …?"

/// The candidate nearest to a mistyped word, if one is near: at most a third of the letters differ, or the word is a
/// prefix of exactly one candidate.
pub(super) fn nearest<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let word = word.to_lowercase();
    let allowed = (word.chars().count() / 3).max(1);
    let near = |c: &&'a str| distance(&word, &c.to_lowercase());
    let slip = candidates.iter().copied().filter(|c| near(c) <= allowed).min_by_key(near);
    let mut longer =
        candidates.iter().copied().filter(|c| word.len() >= 3 && c.to_lowercase().starts_with(&word));
    slip.or_else(|| longer.next().filter(|_| longer.next().is_none()))
}

/// Levenshtein's distance: letters to insert, delete or replace.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

/// Advice for an unknown word: the nearest known word, and all known words.
pub(super) fn ways_out(word: &str, plural: &str, known: &[&str]) -> Vec<String> {
    let mean = nearest(word, known).map(|near| format!("did you mean `{near}`?"));
    let all = match known {
        [] => format!("there are no {plural}"),
        _ => format!("known {plural}: {}", known.join(", ")),
    };
    mean.into_iter().chain([all]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_slips_and_nothing_far_fetched() {
        let known = ["nearest", "linear", "optimised-linear"];
        assert_eq!(nearest("lineer", &known), Some("linear"));
        assert_eq!(nearest("Linear", &known), Some("linear"));
        assert_eq!(nearest("optimized-linear", &known), Some("optimised-linear"));
        assert_eq!(nearest("cubic", &known), None);
        assert_eq!(nearest("optim", &known), Some("optimised-linear"));
        assert_eq!(nearest("", &known), None);
    }
}
