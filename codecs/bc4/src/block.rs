//! The 64 bits of a block, and the levels between its endpoints.

/// Edge of a block in voxels, along x and along y.
pub const EDGE: u32 = 4;
/// Voxels of a block.
pub const TEXELS: usize = 16;
/// Parts per code. Levels are counted in parts, because 35 is a multiple of 7 and 5.
pub const PARTS: u32 = 35;
/// The highest level: code 255.
pub const TOP: i16 = 255 * PARTS as i16;

/// Two endpoints. Their order selects the mode: if the first is larger, eight levels; else six levels, and 0 and 255.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Ends(pub [u8; 2]);

impl Ends {
    /// The levels of the eight indices, in parts of a code ([`PARTS`]), 0 to [`TOP`].
    #[must_use]
    pub fn levels(self) -> [i16; 8] {
        let [first, second] = self.0.map(i16::from);
        let between = |k: i16, of: i16| ((of - k) * first + k * second) * (PARTS as i16 / of);
        let ends = [between(0, 7), between(7, 7)];
        if first > second {
            let [a, b, c, d, e, f] = [1, 2, 3, 4, 5, 6].map(|k| between(k, 7));
            [ends[0], ends[1], a, b, c, d, e, f]
        } else {
            let [a, b, c, d] = [1, 2, 3, 4].map(|k| between(k, 5));
            [ends[0], ends[1], a, b, c, d, 0, TOP]
        }
    }

    /// Whether indices 6 and 7 are 0 and 255.
    #[must_use]
    pub const fn has_extremes(self) -> bool {
        self.0[0] <= self.0[1]
    }

    /// Position of index `i` from the first endpoint to the second, in sevenths, or in fifths in the mode with
    /// extremes. `None` for an extreme.
    #[must_use]
    pub const fn share(self, i: u8) -> Option<i64> {
        let whole = if self.has_extremes() { 5 } else { 7 };
        match i {
            0 => Some(0),
            1 => Some(whole),
            6 | 7 if self.has_extremes() => None,
            _ => Some(i as i64 - 1),
        }
    }
}

/// A block as two words, little-endian. The low 16 bits hold the endpoints. Three bits per voxel follow, x fastest.
#[must_use]
pub fn pack(ends: Ends, indices: &[u8; TEXELS]) -> [u32; 2] {
    let ends = u64::from(ends.0[0]) | u64::from(ends.0[1]) << 8;
    let indices = indices.iter().rev().fold(0, |bits, i| bits << 3 | u64::from(*i));
    let bits = ends | indices << 16;
    [bits as u32, (bits >> 32) as u32]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values of the extension's text, in thirty-fifths.
    #[test]
    fn levels_are_sevenths_or_fifths() {
        assert_eq!(Ends([70, 0]).levels(), [2450, 0, 2100, 1750, 1400, 1050, 700, 350]);
        assert_eq!(Ends([0, 50]).levels(), [0, 1750, 350, 700, 1050, 1400, 0, TOP]);
        assert_eq!(Ends([9, 9]).levels(), [315, 315, 315, 315, 315, 315, 0, TOP]);
        assert_eq!(Ends([255, 254]).levels()[..3], [TOP, 8890, 8920]);
    }

    #[test]
    fn shares_are_where_levels_lie() {
        for ends in [Ends([200, 11]), Ends([11, 200])] {
            let whole = if ends.has_extremes() { 5 } else { 7 };
            let [first, second] = ends.0.map(i64::from);
            for (i, level) in (0..8).zip(ends.levels()) {
                let Some(share) = ends.share(i) else {
                    assert!(level == 0 || level == TOP);
                    continue;
                };
                let sum = (whole - share) * first + share * second;
                assert_eq!(sum * i64::from(PARTS), i64::from(level) * whole);
            }
        }
    }

    #[test]
    fn the_sixth_index_lies_in_both_words() {
        let mut indices = [0; TEXELS];
        indices[5] = 7;
        assert_eq!(pack(Ends([0x12, 0x34]), &indices), [0x8000_3412, 3]);
        indices[15] = 5;
        assert_eq!(pack(Ends([0, 0]), &indices), [0x8000_0000, 0xa000_0003]);
    }
}
