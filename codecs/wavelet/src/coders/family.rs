//! Parents and children: coefficients with the same place and orientation at two levels.

use std::ops::Range;

use crate::stream::pyramid::{Band, Pyramid};

/// The bands of an orientation (0 to 6) at the `levels` coarsest levels, from coarse to fine.
#[must_use]
pub fn orientation(pyramid: &Pyramid, number: usize, levels: usize) -> Vec<&Band> {
    pyramid.coarsest(levels)[1..].iter().skip(number).step_by(7).collect()
}

/// Place of the parent of `p` along an axis of `parents`: `p / 2`, or the last one where a padded band is longer.
#[inline]
const fn above(p: usize, parents: usize) -> usize {
    let (half, last) = (p / 2, parents.saturating_sub(1));
    if half < last { half } else { last }
}

/// Pairs each line of a band with the line of its parent band that holds the parents. That one is empty if the parent
/// band is.
fn lines(child: &Band, parent: &Band) -> impl Iterator<Item = (Range<usize>, Range<usize>)> + use<> {
    let [across, height, depth] = child.extent;
    let [width, rows, slices] = if parent.is_empty() { [0; 3] } else { parent.extent };
    (0..depth).flat_map(move |z| {
        (0..height).map(move |y| {
            let line = (z * height + y) * across;
            let parents = (above(z, slices) * rows + above(y, rows)) * width;
            (line..line + across, parents..parents + width)
        })
    })
}

/// Which coefficients of a band are within trees that end at their parents' band or above.
#[must_use]
pub fn inherited(child: &Band, parent: Option<(&Band, &[bool])>) -> Vec<bool> {
    let mut within = vec![false; child.len()];
    if let Some((parent, covered)) = parent {
        for (line, parents) in lines(child, parent) {
            let (Some(line), Some(parents)) = (within.get_mut(line), covered.get(parents)) else { continue };
            for (x, within) in line.iter_mut().enumerate() {
                *within = parents.get(above(x, parents.len())).copied().unwrap_or(false);
            }
        }
    }
    within
}

/// Which coefficients of the parent band have a descendant that is not 0. `below`: which of the child band have.
#[must_use]
pub fn ancestors(child: &Band, coefficients: &[i32], below: &[bool], parent: &Band) -> Vec<bool> {
    let mut found = vec![false; parent.len()];
    for (line, parents) in lines(child, parent) {
        let parents = &mut found[parents];
        let last = parents.len();
        for (x, i) in line.enumerate() {
            if let Some(parent) = parents.get_mut(above(x, last)) {
                *parent |= coefficients[i] != 0 || below[i];
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn band(extent: [usize; 3]) -> Band {
        Band { level: 1, high: [true; 3], extent, start: 0 }
    }

    #[test]
    fn a_parent_is_at_half_the_place() {
        let (child, parent) = (band([5, 3, 1]), band([2, 2, 1]));
        let covered = inherited(&child, Some((&parent, &[true, false, false, true])));
        let expected = [[1, 1, 0, 0, 0], [1, 1, 0, 0, 0], [0, 0, 1, 1, 1]].concat();
        assert_eq!(covered.iter().map(|c| i32::from(*c)).collect::<Vec<_>>(), expected);
        for i in 0..15 {
            let (mut coefficients, mut below) = ([0; 15], [false; 15]);
            coefficients[i] = -1;
            let parents = ancestors(&child, &coefficients, &below, &parent);
            below[i] = true;
            assert_eq!(ancestors(&child, &[0; 15], &below, &parent), parents);
            let above = usize::from(i % 5 > 1) + 2 * usize::from(i >= 10);
            assert_eq!(parents, [0, 1, 2, 3].map(|p| p == above));
        }
    }

    #[test]
    fn an_empty_band_has_no_children() {
        let (child, parent) = (band([1, 2, 2]), band([0, 1, 1]));
        assert_eq!(inherited(&child, Some((&parent, &[]))), [false; 4]);
        assert_eq!(ancestors(&child, &[1; 4], &[true; 4], &parent).len(), 0);
    }

    #[test]
    fn an_orientation_goes_from_parent_to_child() {
        let pyramid = Pyramid::new([32, 32, 32], 3, false);
        for number in 0..7 {
            let bands = orientation(&pyramid, number, 3);
            assert_eq!(bands.len(), 3);
            assert!(bands.windows(2).all(|pair| pyramid.parent(pair[1]) == Some(pair[0])));
        }
    }
}
