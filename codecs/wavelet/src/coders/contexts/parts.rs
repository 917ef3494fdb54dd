//! Parts of a pyramid that are coded on their own.

use std::ops::Range;

use crate::stream::pyramid::{Band, Pyramid};

/// Levels that are coded with LLL in one chunk, as long as they have no more coefficients: models of their own would
/// cost more than they save.
const TOGETHER: usize = 1 << 16;

/// Coefficients of a slab of a level, about. A slab knows nothing of the slab before it, which costs 0.06 dB at 2¹⁸.
const SLAB: usize = 1 << 21;

/// Slices of the bands of a level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slab {
    /// The level.
    pub level: usize,
    /// Slices of each of its bands. A band may end before.
    pub slices: Range<usize>,
}

impl Slab {
    /// Extent of the part of a band.
    #[must_use]
    pub fn extent(&self, band: &Band) -> [usize; 3] {
        let [x, y, z] = band.extent;
        [x, y, self.slices.end.min(z).saturating_sub(self.slices.start)]
    }

    /// Its coefficients among those of the band.
    #[must_use]
    pub fn places(&self, band: &Band) -> Range<usize> {
        let area = band.extent[0] * band.extent[1];
        let [start, end] = [self.slices.start, self.slices.end].map(|z| z.min(band.extent[2]) * area);
        start..end
    }
}

/// Number of levels in the first chunk.
#[must_use]
pub fn first_levels(pyramid: &Pyramid) -> usize {
    (1..=pyramid.levels()).take_while(|levels| pyramid.coefficients(*levels) <= TOGETHER).count()
}

/// The slabs of a level, each one chunk.
#[must_use]
pub fn slabs(pyramid: &Pyramid, level: usize) -> Vec<Slab> {
    let bands = pyramid.level(level);
    let coefficients: usize = bands.iter().map(Band::len).sum();
    let depth = bands.iter().map(|band| band.extent[2]).max().unwrap_or(0);
    let count = (coefficients / SLAB).clamp(1, depth.max(1));
    let thickness = depth.div_ceil(count).max(1);
    let slab = |z: usize| Slab { level, slices: z..(z + thickness).min(depth) };
    (0..depth).step_by(thickness).map(slab).collect()
}

/// A whole level as one slab.
#[must_use]
pub fn slab_of_all(pyramid: &Pyramid, level: usize) -> Slab {
    let depth = pyramid.level(level).iter().map(|band| band.extent[2]).max().unwrap_or(0);
    Slab { level, slices: 0..depth }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_cover_every_coefficient_once() {
        for extent in [[256, 256, 256], [300, 200, 7], [512, 512, 65], [1, 1, 900]] {
            let pyramid = Pyramid::new(extent, 4, false);
            for level in 0..4 {
                let slabs = slabs(&pyramid, level);
                for band in pyramid.level(level) {
                    let mut at = 0;
                    for slab in &slabs {
                        let places = slab.places(band);
                        assert_eq!((places.start, places.len()), (at, slab.extent(band).iter().product()));
                        at = places.end;
                    }
                    assert_eq!(at, band.len());
                }
            }
        }
    }
}
