//! When two frame times tie: if the middle halves of their measurements overlap.

use crate::experiment::records::record::{NOISY_SPREAD, Record};

/// The middle half of the paired ratios whose median is `relative_frame_time`. Records have only the interquartile range;
/// it is laid evenly around the median. A cell without a spread has none.
fn middle_half(record: &Record) -> Option<[f64; 2]> {
    let half = record.relative_frame_time_iqr.unwrap_or(0.0) / 2.0;
    record.relative_frame_time.map(|time| [time - half, time + half])
}

/// Whether noise hides which of two cells is the faster.
pub(super) fn tie(a: &Record, b: &Record) -> bool {
    match (middle_half(a), middle_half(b)) {
        (Some(a), Some(b)) => a[0] <= b[1] && b[0] <= a[1],
        _ => false,
    }
}

/// Whether the pairs of a cell disagree by so much that its record remarks on it.
pub(super) fn is_noisy(record: &Record) -> bool {
    let spread = record.relative_frame_time_iqr.zip(record.relative_frame_time);
    spread.is_some_and(|(iqr, time)| iqr > NOISY_SPREAD * time)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::records::record::tests::record;

    #[test]
    fn cells_tie_where_their_middle_halves_meet() {
        let timed = |time: f64, iqr: Option<f64>| Record {
            relative_frame_time: Some(time),
            relative_frame_time_iqr: iqr,
            ..record("v", "vq")
        };
        let first = timed(2.0, Some(0.5));
        assert!(!is_noisy(&first) && is_noisy(&timed(2.0, Some(0.51))));
        for (other, ties) in [
            (timed(2.5, Some(0.5)), true),
            (timed(2.51, Some(0.5)), false),
            (timed(1.5, Some(0.5)), true),
            (timed(1.49, Some(0.5)), false),
            (timed(9.0, Some(14.0)), true),
            (timed(2.25, None), true),
            (timed(2.26, None), false),
            (record("v", "vq"), false),
        ] {
            assert_eq!(tie(&first, &other), ties, "{:?}", other.relative_frame_time);
            assert_eq!(tie(&other, &first), ties);
        }
    }
}
