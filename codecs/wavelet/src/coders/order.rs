//! The order in which a coder visits the coefficients of a region (figure 3 of the paper).

/// An order of traversal within a region.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// Line by line, as the coefficients lie in memory (figure 3a).
    Lines,
    /// Depth-first through the octree over the region, cut to its extent (figure 3b): Morton order.
    Octree,
}

/// A place within a region. It starts at the first coefficient of its order.
pub trait Cursor {
    /// Offset of the coefficient among those of the region, x fastest.
    fn offset(&self) -> usize;

    /// Moves on by `coefficients`. More than that many must be left, the current one included.
    fn skip(&mut self, coefficients: usize);
}

/// A place in [`Order::Lines`].
#[derive(Clone, Debug, Default)]
pub struct Lines(usize);

impl Cursor for Lines {
    #[inline]
    fn offset(&self) -> usize {
        self.0
    }

    #[inline]
    fn skip(&mut self, coefficients: usize) {
        self.0 += coefficients;
    }
}

/// A place in [`Order::Octree`]. A node of level `n` is a cube of `2^n` coefficients along each axis.
#[derive(Clone, Debug)]
pub struct Octree {
    extent: [usize; 3],
    place: [usize; 3],
}

impl Octree {
    /// The first coefficient of a region.
    #[must_use]
    pub const fn new(extent: [usize; 3]) -> Self {
        Self { extent, place: [0; 3] }
    }

    /// How many coefficients of the region are in the node that starts here.
    #[inline]
    fn inside(&self, level: u32) -> usize {
        let along = |axis: usize| self.extent[axis].saturating_sub(self.place[axis]).min(1 << level);
        along(0) * along(1) * along(2)
    }

    /// Moves to the next node of this level, which is in Morton order the next number: a carry goes from x to y to z
    /// to the next level.
    #[inline]
    fn step(&mut self, mut level: u32) {
        loop {
            for place in &mut self.place {
                *place ^= 1 << level;
                if *place >> level & 1 == 1 {
                    return;
                }
            }
            level += 1;
        }
    }
}

impl Cursor for Octree {
    #[inline]
    fn offset(&self) -> usize {
        let [x, y, z] = self.place;
        (z * self.extent[1] + y) * self.extent[0] + x
    }

    /// Skips whole nodes: the largest that start here and have no more coefficients than are to be skipped. Nodes
    /// outside the region have none. It ends, because a coefficient of the region lies ahead.
    #[inline]
    fn skip(&mut self, mut coefficients: usize) {
        loop {
            let largest = (self.place[0] | self.place[1] | self.place[2]).trailing_zeros();
            let (mut level, mut inside) = (0, self.inside(0));
            while level < largest {
                let next = self.inside(level + 1);
                if next > coefficients {
                    break;
                }
                (level, inside) = (level + 1, next);
            }
            if inside > coefficients {
                return;
            }
            coefficients -= inside;
            self.step(level);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranks(extent: [usize; 3]) -> Vec<usize> {
        let mut cursor = Octree::new(extent);
        let mut ranks = vec![usize::MAX; extent.iter().product()];
        for rank in 0..ranks.len() {
            if rank > 0 {
                cursor.skip(1);
            }
            assert_eq!(ranks[cursor.offset()], usize::MAX, "{extent:?}");
            ranks[cursor.offset()] = rank;
        }
        ranks
    }

    #[test]
    fn octree_order_is_that_of_figure_3() {
        let ranks = ranks([4; 3]);
        let front = [[0, 1, 8, 9], [2, 3, 10, 11], [16, 17, 24, 25], [18, 19, 26, 27]];
        assert_eq!(ranks[..16], front.concat());
        // Seen from above and from the right, as in the figure: behind 0 lie 4, 32 and 36.
        assert_eq!([ranks[16], ranks[32], ranks[48]], [4, 32, 36]);
        assert_eq!([ranks[3 + 16], ranks[3 + 32], ranks[3 + 48]], [13, 41, 45]);
    }

    #[test]
    fn octree_order_is_cut_to_the_extent() {
        assert_eq!(ranks([3, 2, 1]), [0, 1, 4, 2, 3, 5]);
        // The order within the cube of 8³, without what is outside.
        for extent in [[3, 5, 7], [1, 1, 8], [8, 1, 3], [6, 6, 6]] {
            let inside = |n: usize| {
                let axis = |a: usize| (0..3).map(|bit| (n >> (3 * bit + a) & 1) << bit).sum::<usize>();
                let place = [axis(0), axis(1), axis(2)];
                (0..3)
                    .all(|a| place[a] < extent[a])
                    .then_some((place[2] * extent[1] + place[1]) * extent[0] + place[0])
            };
            let ranks = ranks(extent);
            for (rank, offset) in (0..512).filter_map(inside).enumerate() {
                assert_eq!(ranks[offset], rank, "{extent:?}");
            }
        }
    }

    #[test]
    fn a_skip_is_as_many_steps() {
        let extent = [5, 3, 6];
        let ranks = ranks(extent);
        for first in 0..90 {
            for steps in 0..90 - first {
                let mut cursor = Octree::new(extent);
                cursor.skip(first);
                cursor.skip(steps);
                assert_eq!(ranks[cursor.offset()], first + steps);
            }
        }
    }
}
