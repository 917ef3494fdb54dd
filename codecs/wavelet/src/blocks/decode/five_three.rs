//! 5/3: the twin of five_three.wgsl. Two neighbouring samples along an axis need two low-pass coefficients and three
//! high-pass ones. So a window of 2×2×2 samples needs one of a level coarser, and at most 117 coefficients.

use super::group::ALL;
use super::{Group, Head, place, slot};
use crate::blocks::lift::correction;
use crate::blocks::shape::levels;

/// Slots that are high-pass along x, along y and along z.
const HIGH: [u32; 3] = [0x59, 0x6a, 0x74];

/// Samples `t` and `t + 1` of a line. Each half of the line has `m` coefficients. `low` are low-pass
/// coefficients from `t / 2` on. `high` are high-pass ones from one before.
#[inline]
const fn pair(low: [i32; 2], high: [i32; 3], t: u32, m: u32) -> [i32; 2] {
    let i = t >> 1;
    let before = if i == 0 { high[1] } else { high[0] };
    let even = low[0].wrapping_sub(correction(before, high[1]));
    let next = if i + 1 == m { even } else { low[1].wrapping_sub(correction(high[1], high[2])) };
    let odd = high[1].wrapping_add(even.wrapping_add(next) >> 1);
    if t & 1 == 1 { [odd, next] } else { [even, odd] }
}

/// Samples of a level from `t` on. Along each axis there are `size` of them, one or two. `low` are those of the level
/// before.
fn window(
    head: &Head<'_>,
    root: &Group,
    level: usize,
    low: [i32; 8],
    (t, size): ([u32; 3], [u32; 3]),
) -> [i32; 8] {
    let m = 1_u32 << level;
    let i = t.map(|t| t >> 1);
    let from_low = i.map(|i| i.min(m.max(2) - 2));
    let index = |p: [u32; 3]| (p[0] + 5 * p[1] + 25 * p[2]) as usize;
    // Along each axis: two low-pass coefficients, then three high-pass ones.
    let mut c = [0_i32; 125];
    for k in 0..8_u32 {
        let far = [k & 1, k >> 1 & 1, k >> 2];
        let at = [0, 1, 2].map(|a| (i[a] + far[a]).min(m - 1) - from_low[a]);
        c[index(far)] = low[(at[0] + 2 * at[1] + 4 * at[2]) as usize];
    }
    // An even sample alone needs nothing that follows.
    let ahead = [0, 1, 2].map(|a| if t[a] & 1 == 0 { size[a] } else { 1 });
    let first = i.map(|i| i.max(1) - 1);
    let last = [0, 1, 2].map(|a| (i[a] + ahead[a]).min(m - 1));
    let (mut group, mut held) = (*root, 0);
    for z in first[2]..=last[2] {
        for y in first[1]..=last[1] {
            for x in first[0]..=last[0] {
                let p = [x, y, z];
                let (of, place) = place(level, p);
                if of != held {
                    (group, held) = (head.child(of as u32 - 1), of);
                }
                let record = group.record(place);
                if record.is_empty() {
                    continue;
                }
                // 0, 1 or 2: the position before, that of the first sample, the one after.
                let nth = [0, 1, 2].map(|a| p[a] + 1 - i[a]);
                // No low-pass coefficient is needed before the first.
                let wanted = (0..3).filter(|a| nth[*a] == 0).fold(ALL, |wanted, a| wanted & HIGH[a]);
                let high = head.coefficients(record, level, wanted);
                for axes in (1..8_usize).filter(|axes| wanted >> slot(*axes) & 1 == 1) {
                    let at = [0, 1, 2].map(|a| nth[a] + 3 * (axes >> a & 1) as u32 - 1);
                    c[index(at)] = high[slot(axes)];
                }
            }
        }
    }
    let by_x: [[i32; 2]; 25] = std::array::from_fn(|k| {
        let c = &c[5 * k..];
        pair([c[0], c[1]], [c[2], c[3], c[4]], t[0], m)
    });
    let mut out = [0; 8];
    for x in 0..2 {
        let by_y: [[i32; 2]; 5] = std::array::from_fn(|k| {
            let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(|n| by_x[5 * k + n][x]);
            pair([a, b], [c, d, e], t[1], m)
        });
        for y in 0..2 {
            let [a, b, c, d, e] = by_y.map(|pair| pair[y]);
            let pair = pair([a, b], [c, d, e], t[2], m);
            out[x + 2 * y] = pair[0];
            out[x + 2 * y + 4] = pair[1];
        }
    }
    out
}

/// The integers at the corners of a cell, which reaches one further along the axes of `size`.
pub fn corners(head: &Head<'_>, inside: [u32; 3], size: [u32; 3]) -> [i32; 8] {
    let mut samples = [head.low; 8];
    if head.coded {
        let (root, levels) = (head.root(), levels(head.frame.shape.edge()));
        for level in 0..levels {
            let left = levels - 1 - level;
            // Windows of coarser levels have two samples along each axis, all inside the block.
            let cut = inside.map(|v| (v >> left).min((2 << level) - 2));
            let of = if left > 0 { (cut, [1; 3]) } else { (inside, size) };
            samples = window(head, &root, level, samples, of);
        }
    }
    std::array::from_fn(|k| {
        let far = [0, 1, 2].map(|a| (k >> a) as u32 & size[a]);
        samples[(far[0] + 2 * far[1] + 4 * far[2]) as usize]
    })
}

/// The integer at a position.
#[inline]
pub fn one(head: &Head<'_>, inside: [u32; 3]) -> i32 {
    corners(head, inside, [0; 3])[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::shape::AXES;

    #[test]
    fn slots_are_high_along_their_axes() {
        for (a, high) in HIGH.into_iter().enumerate() {
            let slots = (0..7).filter(|slot| AXES[*slot] >> a & 1 == 1).map(|slot| 1 << slot);
            assert_eq!(slots.sum::<u32>(), high);
        }
    }
}
