//! How far the surfaces that a transfer function shows are from where they were.
//!
//! An isosurface crosses an edge between neighbouring voxels if one of them has at least the isovalue and the other has
//! less. The crossing lies where a straight line between the two values has the isovalue. These crossings, in voxels,
//! represent the surface. The distance from a crossing of one volume to the nearest of the other is exact up to [`REACH`]
//! voxels; a larger one counts as [`REACH`]. At most [`SAMPLES`] crossings of each volume are measured, drawn by a hash of
//! their number alone, against all crossings of the other.

use rayon::prelude::*;

use crate::metrics::{Better, Figure};
use crate::render::TransferFunction;

/// Approximate number of crossings whose distance is measured. If a volume has more, each is drawn with the matching
/// probability.
pub const SAMPLES: u64 = 10_000;
/// Largest distance that is measured, in voxels.
pub const REACH: usize = 8;
/// Isovalues of a transfer function that count.
pub const ISOVALUES: usize = 3;

/// The figures of this metric.
pub(super) const FIGURES: &[Figure] = &[
    Figure {
        name: "isosurface_distance_voxels",
        heading: "isosurface distance",
        axis: "mean distance of the isosurfaces, voxels",
        unit: "voxels",
        better: Better::Lower,
        definition: "mean distance between the isosurfaces of original and decoded volume at the steepest ramps of the \
                     scene's opacity, both ways; infinite where one volume lacks a surface, empty where both do",
    },
    Figure {
        name: "isosurface_max_distance_voxels",
        heading: "largest isosurface distance",
        axis: "largest distance of the isosurfaces, voxels",
        unit: "voxels",
        better: Better::Lower,
        definition: "the largest of those distances, 8 at most where both volumes have the surface",
    },
];

/// Distance between surfaces, in voxels.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SurfaceDistance {
    /// Mean of both ways, and of the isovalues; infinite where one of the volumes lacks a surface.
    pub mean: f64,
    /// The largest.
    pub max: f64,
}

impl SurfaceDistance {
    /// Several as one: the mean of the means, and the largest; `None` of none.
    #[must_use]
    pub fn pooled(distances: impl IntoIterator<Item = Self>) -> Option<Self> {
        let (mut sum, mut max, mut n) = (0.0, 0.0_f64, 0.0);
        for distance in distances {
            sum += distance.mean;
            max = max.max(distance.max);
            n += 1.0;
        }
        (n > 0.0).then(|| Self { mean: sum / n, max })
    }
}

/// The isovalues at which a transfer function shows edges: the middle of each ramp between control points of different
/// opacity, the steepest (opacity per data value; a step is steepest) first, [`ISOVALUES`] at most. Of equally steep ones
/// the larger change comes first, then the lower value.
#[must_use]
pub fn edges(function: &TransferFunction) -> Vec<f32> {
    let mut ramps: Vec<(f64, f64, f32)> = Vec::new();
    for pair in function.points().windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let change = (f64::from(b.rgba[3]) - f64::from(a.rgba[3])).abs();
        if change > 0.0 {
            let (low, high) = (f64::from(a.value), f64::from(b.value));
            ramps.push((change / (high - low), change, f64::midpoint(low, high) as f32));
        }
    }
    ramps.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1)).then(a.2.total_cmp(&b.2)));
    let mut isovalues: Vec<f32> = ramps.into_iter().map(|ramp| ramp.2).collect();
    isovalues.dedup();
    isovalues.truncate(ISOVALUES);
    isovalues
}

/// Distance between the surfaces of two scalar fields of equal extent (x fastest) at isovalues; `None` where neither
/// has any of the surfaces.
///
/// # Panics
/// When a field has not one value per voxel.
#[must_use]
pub fn distance(
    original: &[f32],
    decoded: &[f32],
    extent: [u32; 3],
    isovalues: &[f32],
) -> Option<SurfaceDistance> {
    let extent = extent.map(|n| n as usize);
    assert!(
        original.len() == extent.iter().product::<usize>() && decoded.len() == original.len(),
        "one value per voxel"
    );
    SurfaceDistance::pooled(isovalues.iter().filter_map(|&iso| {
        let [a, b] = [original, decoded].map(|values| Surface::new(values, extent, iso));
        let (in_a, in_b) = (a.crossings_per_slice(), b.crossings_per_slice());
        match (in_a.iter().sum::<u64>(), in_b.iter().sum::<u64>()) {
            (0, 0) => None,
            (0, _) | (_, 0) => Some(SurfaceDistance { mean: f64::INFINITY, max: f64::INFINITY }),
            _ => {
                let ways = [a.distances_to(&in_a, &b), b.distances_to(&in_b, &a)];
                SurfaceDistance::pooled(ways)
            }
        }
    }))
}

/// The surface of one value in one field.
struct Surface<'a> {
    values: &'a [f32],
    extent: [usize; 3],
    iso: f32,
    /// A bit per voxel that has at least the isovalue, 64 to a word; a row begins a word.
    inside: Vec<u64>,
}

/// Voxels of a row that are looked at together: one less than bits in a word, for the neighbour of the last.
const RUN: usize = 63;

impl<'a> Surface<'a> {
    fn new(values: &'a [f32], extent: [usize; 3], iso: f32) -> Self {
        let word = |values: &[f32]| values.iter().rev().fold(0, |word, v| word << 1 | u64::from(*v >= iso));
        let rows = values.par_chunks(extent[0]);
        let inside = rows.flat_map_iter(|row| row.chunks(64).map(word)).collect();
        Self { values, extent, iso, inside }
    }

    /// Bits of `n` ≤ 64 voxels of a row.
    fn bits(&self, [x, y, z]: [usize; 3], n: usize) -> u64 {
        let words = self.extent[0].div_ceil(64);
        let row = &self.inside[(z * self.extent[1] + y) * words..][..words];
        let (word, shift) = (x / 64, x % 64);
        let mut bits = row[word] >> shift;
        if shift + n > 64 {
            bits |= row[word + 1] << (64 - shift);
        }
        bits & (u64::MAX >> (64 - n))
    }

    /// Which of the `n` ≤ [`RUN`] voxels from `p` on along x begin an edge that crosses, for each axis. Edges end before
    /// `end`.
    fn crossing(&self, p: [usize; 3], n: usize, end: [usize; 3]) -> [u64; 3] {
        let own = self.bits(p, n);
        let next = (end[0] - p[0] - 1).min(n);
        let mut crossing = [0; 3];
        if next > 0 {
            crossing[0] = (own ^ self.bits([p[0] + 1, p[1], p[2]], next)) & (u64::MAX >> (64 - next));
        }
        if p[1] + 1 < end[1] {
            crossing[1] = own ^ self.bits([p[0], p[1] + 1, p[2]], n);
        }
        if p[2] + 1 < end[2] {
            crossing[2] = own ^ self.bits([p[0], p[1], p[2] + 1], n);
        }
        crossing
    }

    /// Crossings of the edges that begin in each slice.
    fn crossings_per_slice(&self) -> Vec<u64> {
        let [width, height, depth] = self.extent;
        let of_row = |y: usize, z: usize| -> u64 {
            let runs = (0..width).step_by(RUN);
            let run = |x: usize| self.crossing([x, y, z], RUN.min(width - x), self.extent);
            runs.flat_map(run).map(|bits| u64::from(bits.count_ones())).sum()
        };
        (0..depth).into_par_iter().map(|z| (0..height).map(|y| of_row(y, z)).sum()).collect()
    }

    /// Calls with every crossing of the edges that begin in a run and end before `end`.
    fn each_crossing(&self, p: [usize; 3], n: usize, end: [usize; 3], mut each: impl FnMut([f64; 3])) {
        let steps = [1, self.extent[0], self.extent[0] * self.extent[1]];
        let row = p[0] + p[1] * steps[1] + p[2] * steps[2];
        for (axis, mut bits) in self.crossing(p, n, end).into_iter().enumerate() {
            while bits != 0 {
                let x = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let (from, to) = (row + x, row + x + steps[axis]);
                let [a, b, iso] = [self.values[from], self.values[to], self.iso].map(f64::from);
                let mut place = [p[0] + x, p[1], p[2]].map(|n| n as f64);
                place[axis] += (iso - a) / (b - a);
                each(place);
            }
        }
    }

    /// Mean and largest distance from crossings of this surface, `counted` by slice, to another.
    fn distances_to(&self, counted: &[u64], other: &Self) -> SurfaceDistance {
        let total: u64 = counted.iter().sum();
        let mut before = 0;
        let first_numbers: Vec<u64> = counted
            .iter()
            .map(|n| {
                before += n;
                before - n
            })
            .collect();
        let drawn = |number: u64| total <= SAMPLES || hash(number) % total < SAMPLES;
        // Slices are fixed pieces and are added up in their order.
        let slices: Vec<(f64, f64, u64)> = (0..self.extent[2])
            .into_par_iter()
            .map(|z| {
                let mut number = first_numbers[z];
                let (mut sum, mut max, mut n) = (0.0, 0.0_f64, 0);
                for y in (0..self.extent[1]).filter(|_| counted[z] > 0) {
                    for x in (0..self.extent[0]).step_by(RUN) {
                        self.each_crossing([x, y, z], RUN.min(self.extent[0] - x), self.extent, |place| {
                            if drawn(number) {
                                let nearest = other.nearest(place);
                                (sum, max, n) = (sum + nearest, max.max(nearest), n + 1);
                            }
                            number += 1;
                        });
                    }
                }
                (sum, max, n)
            })
            .collect();
        let (sum, max, n) =
            slices.into_iter().fold((0.0, 0.0_f64, 0), |a, b| (a.0 + b.0, a.1.max(b.1), a.2 + b.2));
        SurfaceDistance { mean: sum / n.max(1) as f64, max }
    }

    /// Distance from a place to the nearest crossing, [`REACH`] at most.
    fn nearest(&self, place: [f64; 3]) -> f64 {
        let reach = REACH as f64;
        let mut best = reach * reach;
        let mut radius = 1;
        while radius <= REACH {
            // All edges within the box; what lies beyond it is at least `radius` away.
            let first = place.map(|p| (p as usize).saturating_sub(radius));
            let end = [0, 1, 2].map(|a| (place[a] as usize + radius + 2).min(self.extent[a]));
            for z in first[2]..end[2] {
                for y in first[1]..end[1] {
                    // Edges that begin in this row reach to the next.
                    let gap = |n: usize, p: f64| (n as f64 - p).max(p - n as f64 - 1.0).max(0.0);
                    if gap(y, place[1]).powi(2) + gap(z, place[2]).powi(2) < best {
                        self.each_crossing([first[0], y, z], end[0] - first[0], end, |q| {
                            let squared: f64 = q.iter().zip(place).map(|(q, p)| (q - p) * (q - p)).sum();
                            best = best.min(squared);
                        });
                    }
                }
            }
            if best <= (radius * radius) as f64 {
                break;
            }
            radius *= 2;
        }
        best.sqrt()
    }
}

/// A pseudo-random number: the finaliser of SplitMix64 (Steele, Lea & Flood 2014).
const fn hash(number: u64) -> u64 {
    let mut h = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    h = (h ^ (h >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h = (h ^ (h >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    h ^ (h >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::ControlPoint;

    const SIZE: [u32; 3] = [20, 12, 9];

    fn field(value: impl Fn([f32; 3]) -> f32) -> Vec<f32> {
        let [x, y, z] = SIZE;
        let places = (0..z).flat_map(|k| (0..y).flat_map(move |v| (0..x).map(move |u| [u, v, k])));
        places.map(|p| value(p.map(|n| n as f32))).collect()
    }

    fn of(a: &[f32], b: &[f32], iso: f32) -> Option<(f64, f64)> {
        distance(a, b, SIZE, &[iso]).map(|d| (d.mean, d.max))
    }

    #[test]
    fn a_plane_that_moves_is_as_far_as_it_moved() {
        for axis in 0..3 {
            let plane = |shift: f32| field(move |p| p[axis] + shift);
            // Crossings at 4.5 and at 4.25, then at 2.5: beyond a first box.
            assert_eq!(of(&plane(0.0), &plane(0.25), 4.5), Some((0.25, 0.25)), "{axis}");
            assert_eq!(of(&plane(0.0), &plane(2.0), 4.5), Some((2.0, 2.0)), "{axis}");
            assert_eq!(of(&plane(0.0), &plane(0.0), 4.5), Some((0.0, 0.0)), "{axis}");
        }
        // More than the reach counts as it.
        let far = field(|p| p[0] - 10.0);
        assert_eq!(of(&field(|p| p[0]), &far, 4.5), Some((8.0, 8.0)));
    }

    #[test]
    fn a_spot_that_one_volume_lacks_counts_in_one_way() {
        let plane = field(|p| p[0]);
        let mut spotted = plane.clone();
        // One voxel at x = 8 falls below: six crossings about it.
        let at = 8 + 20 * 6 + 20 * 12 * 4;
        spotted[at] = 1.0;
        let (mean, max) = of(&plane, &spotted, 4.5).unwrap();
        // From 7 down to 1, from 1 up to 9, and half-way to the four neighbours of value 8, half a voxel off the grid of
        // the plane's crossings.
        let (x0, x1) = (7.0 + 2.5 / 6.0, 8.0 + 3.5 / 8.0);
        let sum = (x0 - 4.5) + (x1 - 4.5) + 4.0 * 3.5_f64.hypot(0.5);
        assert!((max - (x1 - 4.5)).abs() < 1e-12, "{max}");
        assert!((mean - sum / (12.0 * 9.0 + 6.0) / 2.0).abs() < 1e-12, "{mean} {sum}");
    }

    #[test]
    fn a_surface_that_one_volume_lacks_is_endlessly_far_and_one_that_both_lack_is_none() {
        let (plane, flat) = (field(|p| p[0]), field(|_| 0.0));
        assert_eq!(of(&plane, &flat, 4.5), Some((f64::INFINITY, f64::INFINITY)));
        assert_eq!(of(&flat, &plane, 4.5), Some((f64::INFINITY, f64::INFINITY)));
        assert_eq!(of(&flat, &flat, 4.5), None);
        assert_eq!(distance(&plane, &plane, SIZE, &[]), None);
        // Isovalues that both lack do not count.
        let moved = field(|p| p[0] + 0.5);
        let d = distance(&plane, &moved, SIZE, &[4.5, 99.0, 6.5]).unwrap();
        assert_eq!((d.mean, d.max), (0.5, 0.5));
    }

    #[test]
    fn what_is_drawn_of_many_crossings_does_not_depend_on_threads() {
        // More than ten thousand crossings, with distances of their own.
        let size = [64, 64, 64];
        let noise =
            |seed: u64| -> Vec<f32> { (0..64 * 64 * 64).map(|i| (hash(i + seed) >> 40) as f32).collect() };
        let (a, b) = (noise(0), noise(1 << 40));
        let middle = (1u32 << 23) as f32;
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| distance(&a, &b, size, &[middle]).unwrap())
        };
        let (one, four) = (on(1), on(4));
        assert_eq!((one.mean.to_bits(), one.max.to_bits()), (four.mean.to_bits(), four.max.to_bits()));
        assert!(one.mean > 0.05 && one.max > one.mean && one.max < 8.0);
    }

    #[test]
    fn edges_are_the_middles_of_the_steepest_ramps() {
        let edges_of = |points: &[(f32, f32)]| {
            let points = points.iter().map(|&(value, a)| ControlPoint { value, rgba: [0.0, 0.0, 0.0, a] });
            edges(&TransferFunction::new(points.collect()).unwrap())
        };
        assert_eq!(edges_of(&[(110.0, 0.0), (128.0, 1.0), (255.0, 1.0)]), [119.0]);
        // A step, then a steep ramp, then the larger of two of equal slope; the fourth does not count.
        let many = [(0.0, 0.0), (10.0, 0.1), (30.0, 0.3), (40.0, 0.3), (40.0, 0.9), (42.0, 0.1)];
        assert_eq!(edges_of(&many), [40.0, 41.0, 20.0]);
        assert_eq!(edges_of(&[(0.0, 0.5), (9.0, 0.5)]), [0.0; 0]);
    }
}
