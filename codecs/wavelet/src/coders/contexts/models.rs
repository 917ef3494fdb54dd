//! The models of the symbols of a band.

use super::adaptive::Adaptive;

/// Number of classes of activity.
const CLASSES: usize = 64;

/// Largest number of bits of a magnitude.
const BITS: usize = 32;

/// The class of an activity: exact below 8, four to the octave above.
#[inline]
#[must_use]
pub fn class(activity: u16) -> usize {
    if activity < 8 {
        return activity as usize;
    }
    let octave = 15 - activity.leading_zeros() as usize;
    8 + 4 * (octave - 3) + (activity as usize >> (octave - 2) & 3)
}

/// Signs of the coefficients before one along x, y and z: -1, 0 or 1 each.
#[inline]
#[must_use]
pub const fn signs(before: [i32; 3]) -> usize {
    let [x, y, z] = before;
    (13 + x.signum() + 3 * y.signum() + 9 * z.signum()) as usize
}

/// The models of the bands of one kind.
#[derive(Clone, Debug)]
pub struct Models {
    /// Whether a segment in quiet surroundings has a coefficient that is not 0.
    pub segment: Adaptive,
    /// Whether a coefficient is not 0.
    pub nonzero: [Adaptive; CLASSES],
    /// Whether a magnitude has more than this many bits plus one.
    pub longer: [[Adaptive; CLASSES]; BITS],
    /// The bit below the highest one, by the number of bits below it.
    pub second: [[Adaptive; CLASSES]; BITS],
    /// The bit below that, by the second one.
    pub third: [[Adaptive; 2]; BITS],
    /// Whether a coefficient is negative, by the number of the band and by [`signs`].
    pub negative: [[Adaptive; 27]; 8],
}

impl Default for Models {
    fn default() -> Self {
        let new = Adaptive::default();
        Self {
            segment: new,
            nonzero: [new; CLASSES],
            longer: [[new; CLASSES]; BITS],
            second: [[new; CLASSES]; BITS],
            third: [[new; 2]; BITS],
            negative: [[new; 27]; 8],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_grow_with_activity_and_none_is_left_out() {
        let all: Vec<usize> = (0..=u16::MAX).map(class).collect();
        assert!(all.windows(2).all(|pair| pair[1] == pair[0] || pair[1] == pair[0] + 1));
        assert_eq!((all[0], all[7], all[8], all[65535]), (0, 7, 8, CLASSES - 5));
    }

    #[test]
    fn signs_have_numbers_of_their_own() {
        assert_eq!(
            [signs([-9, -9, -9]), signs([0, 0, 0]), signs([1, 0, 0]), signs([5, 5, 5])],
            [0, 13, 14, 26]
        );
    }
}
