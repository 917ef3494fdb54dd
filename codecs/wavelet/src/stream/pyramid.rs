//! Shapes of the bands of a transformed volume, and their order in a stream.

/// The coefficients of one band: those that passed the high-pass filter along some axes at one level, and the low-pass
/// filter along all others.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Band {
    /// 0 is the coarsest level, as in the paper.
    pub level: usize,
    /// Whether the band is high-pass along x, y and z. All `false` for LLL, which only level 0 has.
    pub high: [bool; 3],
    /// Coefficients along x, y and z. An axis may be 0: a line of one sample has no high-pass coefficient.
    pub extent: [usize; 3],
    /// Its first coefficient among those of all bands.
    pub start: usize,
}

impl Band {
    /// Number of coefficients.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.extent[0] * self.extent[1] * self.extent[2]
    }

    /// Whether it has none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many axes are high-pass: 0 to 3. LLH, LHL and HLL are of one kind.
    #[must_use]
    pub fn kind(&self) -> usize {
        self.high.iter().filter(|high| **high).count()
    }

    /// Place of its coefficients among those of all bands.
    #[must_use]
    pub const fn range(&self) -> std::ops::Range<usize> {
        self.start..self.start + self.len()
    }
}

/// The bands of a transform. LLL comes first, then the seven bands of level 0, then those of level 1, and so on. The
/// seven bands of a level are ordered by the number whose bit 0, 1 and 2 say whether x, y and z are high-pass: 1 to 7.
/// Within a band, x is fastest. A coarse volume therefore needs a prefix of the coefficients.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pyramid {
    bands: Vec<Band>,
    /// Extent of the volume at each resolution, the full one first.
    extents: Vec<[usize; 3]>,
}

impl Pyramid {
    /// The bands of a volume of `extent` voxels after `decompositions`. `padded`: a line of an odd number of samples
    /// above 1 is extended by one sample before it is transformed, so both halves have the same length.
    #[must_use]
    pub fn new(extent: [usize; 3], decompositions: usize, padded: bool) -> Self {
        let mut extents = vec![extent];
        for level in 0..decompositions {
            extents.push(extents[level].map(|n| n.div_ceil(2)));
        }
        let mut bands = vec![Band { level: 0, high: [false; 3], extent: extents[decompositions], start: 0 }];
        let mut start = bands[0].len();
        for level in 0..decompositions {
            let whole = extents[decompositions - 1 - level];
            for number in 1..8 {
                let high = [0, 1, 2].map(|axis| number >> axis & 1 == 1);
                let extent = [0, 1, 2].map(|axis| match (whole[axis], high[axis]) {
                    (n, false) => n.div_ceil(2),
                    (1, true) => 0,
                    (n, true) if padded => n.div_ceil(2),
                    (n, true) => n / 2,
                });
                let band = Band { level, high, extent, start };
                start += band.len();
                bands.push(band);
            }
        }
        Self { bands, extents }
    }

    /// All bands in order.
    #[must_use]
    pub fn bands(&self) -> &[Band] {
        &self.bands
    }

    /// Place of a band in [`Pyramid::bands`].
    #[must_use]
    pub fn number(&self, band: &Band) -> usize {
        7 * band.level + band.high.iter().rev().fold(0, |bits, high| 2 * bits + usize::from(*high))
    }

    /// Number of levels.
    #[must_use]
    pub const fn levels(&self) -> usize {
        self.extents.len() - 1
    }

    /// LLL and the bands of the `levels` coarsest levels.
    #[must_use]
    pub fn coarsest(&self, levels: usize) -> &[Band] {
        &self.bands[..1 + 7 * levels]
    }

    /// The seven bands of a level.
    #[must_use]
    pub fn level(&self, level: usize) -> &[Band] {
        &self.bands[1 + 7 * level..8 + 7 * level]
    }

    /// The band whose coefficient at `p / 2` has the same place as this one's at `p`, one level coarser. `None` for
    /// LLL and the bands of level 0.
    #[must_use]
    pub fn parent(&self, band: &Band) -> Option<&Band> {
        (band.level > 0).then(|| &self.bands[self.number(band) - 7])
    }

    /// Number of coefficients of LLL and the `levels` coarsest levels.
    #[must_use]
    pub fn coefficients(&self, levels: usize) -> usize {
        self.coarsest(levels).last().map_or(0, |band| band.range().end)
    }

    /// Voxels of the volume after `decompositions` of its transform: 0 is the full resolution.
    #[must_use]
    pub fn extent(&self, decompositions: usize) -> [usize; 3] {
        self.extents[decompositions]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_follow_each_other_from_the_coarsest_on() {
        let pyramid = Pyramid::new([13, 8, 1], 3, false);
        assert_eq!(pyramid.coefficients(3), 13 * 8);
        assert_eq!(pyramid.bands()[0].extent, [2, 1, 1]);
        assert_eq!(
            pyramid.level(2)[0],
            Band { level: 2, high: [true, false, false], extent: [6, 4, 1], start: 28 }
        );
        assert_eq!(pyramid.extent(1), [7, 4, 1]);
        assert!(pyramid.bands().iter().enumerate().all(|(number, band)| pyramid.number(band) == number));
        for pair in pyramid.bands().windows(2) {
            assert_eq!(pair[0].range().end, pair[1].start);
        }
        // One more coefficient per axis of odd length.
        assert_eq!(Pyramid::new([13, 8, 1], 1, true).coefficients(1), 14 * 8);
        assert_eq!(Pyramid::new([13, 8, 1], 0, true).coefficients(0), 13 * 8);
    }

    #[test]
    fn a_parent_has_the_same_axes_one_level_coarser() {
        let pyramid = Pyramid::new([64, 64, 64], 4, false);
        assert_eq!(pyramid.parent(&pyramid.bands()[0]), None);
        assert_eq!(pyramid.parent(&pyramid.level(0)[3]), None);
        for level in 1..4 {
            for (band, parent) in pyramid.level(level).iter().zip(pyramid.level(level - 1)) {
                assert_eq!(pyramid.parent(band), Some(parent));
            }
        }
    }
}
