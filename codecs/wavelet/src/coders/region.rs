//! A region (the coefficients of a band) as runs of zeros and values.

use super::{fault::Fault, order::Cursor};

/// What an encoder reads from a region.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    /// This many zeros, at least 1. The next piece, if there is one, is no run.
    Zeros(usize),
    /// A value other than 0.
    Value(i32),
}

/// A region in pieces.
pub fn pieces(mut cursor: impl Cursor, coefficients: &[i32]) -> impl Iterator<Item = Piece> {
    let mut values = (0..coefficients.len())
        .map(move |i| {
            cursor.skip(usize::from(i > 0));
            coefficients[cursor.offset()]
        })
        .peekable();
    std::iter::from_fn(move || {
        let first = values.next()?;
        if first != 0 {
            return Some(Piece::Value(first));
        }
        let mut zeros = 1;
        while values.next_if(|value| *value == 0).is_some() {
            zeros += 1;
        }
        Some(Piece::Zeros(zeros))
    })
}

/// Where a decoder writes a region. All its coefficients are 0 at first, so a run of zeros is a skip.
pub struct Region<'a, C> {
    cursor: C,
    out: &'a mut [i32],
    left: usize,
}

impl<'a, C: Cursor> Region<'a, C> {
    /// A region of `out`. The cursor is at its first coefficient.
    pub const fn new(cursor: C, out: &'a mut [i32]) -> Self {
        let left = out.len();
        Self { cursor, out, left }
    }

    /// How many coefficients have not been written yet.
    #[inline]
    pub const fn left(&self) -> usize {
        self.left
    }

    /// Writes a run of zeros.
    ///
    /// # Errors
    /// The region has no room for it.
    #[inline]
    pub fn zeros(&mut self, zeros: usize) -> Result<(), Fault> {
        self.left =
            self.left.checked_sub(zeros).ok_or(Fault("a run of zeros passes the end of its region"))?;
        // There is no place to skip to after the last coefficient.
        if self.left > 0 {
            self.cursor.skip(zeros);
        }
        Ok(())
    }

    /// Writes a value.
    ///
    /// # Errors
    /// The region has no room for it.
    #[inline]
    pub fn value(&mut self, value: i32) -> Result<(), Fault> {
        let place = self.out.get_mut(self.cursor.offset()).filter(|_| self.left > 0);
        *place.ok_or(Fault("a value follows the end of its region"))? = value;
        self.zeros(1)
    }

    /// Checks that the region is complete.
    ///
    /// # Errors
    /// It is not.
    pub fn finish(self) -> Result<(), Fault> {
        if self.left == 0 { Ok(()) } else { Err(Fault("bytes end before their region")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coders::order::Lines;

    #[test]
    fn a_region_takes_what_it_has_room_for() {
        let mut out = [0; 4];
        let mut region = Region::new(Lines::default(), &mut out);
        assert!(region.zeros(5).is_err());
        region.zeros(2).unwrap();
        region.value(7).unwrap();
        assert_eq!(region.left(), 1);
        region.value(-1).unwrap();
        assert!(region.value(1).is_err());
        assert!(region.zeros(1).is_err());
        region.finish().unwrap();
        assert_eq!(out, [0, 0, 7, -1]);
        assert!(Region::new(Lines::default(), &mut out).finish().is_err());
    }

    #[test]
    fn pieces_alternate() {
        let all = |coefficients: &[i32]| pieces(Lines::default(), coefficients).collect::<Vec<_>>();
        assert_eq!(all(&[]), []);
        assert_eq!(
            all(&[0, 0, 3, -4, 0]),
            [Piece::Zeros(2), Piece::Value(3), Piece::Value(-4), Piece::Zeros(1)]
        );
    }
}
