//! Pooling: how a cell's value of a column is computed from its frames. Each function takes the cell's value and those of
//! its frames, at least two.

use std::ops::Add;

/// The cell's value stays.
pub(super) fn of_cell<'a, T: 'a>(_: &mut T, _: impl Iterator<Item = &'a T>) {}

/// The cell's value stays. It was pooled from the pixels of all frames.
pub(super) fn of_pictures<'a, T: 'a>(_: &mut T, _: impl Iterator<Item = &'a T>) {}

/// The value of the first frame.
pub(super) fn first<'a, T: Clone + 'a>(own: &mut T, mut frames: impl Iterator<Item = &'a T>) {
    if let Some(first) = frames.next() {
        *own = first.clone();
    }
}

/// The median of the measured values.
pub(super) fn median<'a>(own: &mut Option<f64>, frames: impl Iterator<Item = &'a Option<f64>>) {
    *own = middle(frames.copied().flatten().collect());
}

/// The largest of the measured values.
pub(super) fn most<'a, T: Ord + Copy + 'a>(own: &mut Option<T>, frames: impl Iterator<Item = &'a Option<T>>) {
    *own = frames.copied().flatten().max();
}

/// The sum of the measured values.
pub(super) fn sum<'a, T: Copy + Add<Output = T> + 'a>(
    own: &mut Option<T>,
    frames: impl Iterator<Item = &'a Option<T>>,
) {
    *own = frames.copied().flatten().reduce(|a, b| a + b);
}

/// The cell's remarks, then those of its frames. Equal ones once.
pub(super) fn remarks<'a>(own: &mut Option<String>, frames: impl Iterator<Item = &'a Option<String>>) {
    let mut said: Vec<String> = own.iter().flat_map(|notes| notes.split("; ")).map(str::to_owned).collect();
    for remark in frames.flatten().flat_map(|notes| notes.split("; ")) {
        if !said.iter().any(|before| before == remark) {
            add_remark(own, remark);
            said.push(remark.to_owned());
        }
    }
}

/// Adds a remark.
pub(super) fn add_remark(notes: &mut Option<String>, text: &str) {
    match notes {
        Some(notes) => notes.extend(["; ", text]),
        None => *notes = Some(text.to_owned()),
    }
}

fn middle(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let upper = values.get(values.len() / 2)?;
    Some((values[(values.len() - 1) / 2] + upper) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_measured_does_not_count() {
        let pooled = |how: fn(&mut Option<u64>, std::slice::Iter<'_, Option<u64>>),
                      frames: &[Option<u64>]| {
            let mut own = Some(9);
            how(&mut own, frames.iter());
            own
        };
        let frames = [None, Some(3), Some(5)];
        assert_eq!(pooled(|own, frames| sum(own, frames), &frames), Some(8));
        assert_eq!(pooled(|own, frames| most(own, frames), &frames), Some(5));
        assert_eq!(pooled(|own, frames| sum(own, frames), &[None]), None);
        assert_eq!(pooled(|own, frames| first(own, frames), &frames), None);
        assert_eq!(pooled(|own, frames| of_cell(own, frames), &frames), Some(9));
        let mut own = None;
        median(&mut own, [Some(4.0), None, Some(1.0)].iter());
        assert_eq!(own, Some(2.5));
        assert_eq!(middle(vec![]), None);
    }
}
