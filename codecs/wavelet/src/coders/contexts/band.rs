//! One part of a band, coefficient by coefficient.

use super::magnitudes::{Magnitudes, NEAR, Parents, counted};
use super::models::{Models, class, signs};
use crate::coders::fault::Fault;

/// Coefficients of a segment: if all surroundings are 0, one symbol says whether a segment is.
const SEGMENT: usize = 16;

/// One side of the coder: what reads coefficients, what writes given ones, or what chooses and writes them. All sides
/// make the same calls in the same order.
pub trait Side {
    /// Whether coefficients `places` of the band's part are not all 0. All their surroundings are.
    ///
    /// # Errors
    /// The bytes are corrupt.
    fn segment(&mut self, models: &mut Models, places: std::ops::Range<usize>) -> Result<bool, Fault>;

    /// The coefficient at `place` of the band's part, in surroundings of a class. `negative` is the number of the
    /// band and the signs before the coefficient.
    ///
    /// # Errors
    /// The bytes are corrupt.
    fn coefficient(
        &mut self,
        models: &mut Models,
        place: usize,
        class: usize,
        negative: impl Fn() -> (usize, usize),
    ) -> Result<i32, Fault>;
}

/// What is known about a part of a band before it is coded.
#[derive(Copy, Clone, Debug)]
pub struct Known<'a> {
    /// Number of the band in its level: 1 to 7, or 0 for LLL.
    pub number: usize,
    /// Its parents, if there are any.
    pub parents: Option<Parents<'a>>,
    /// The same parts of the bands before it in its level.
    pub done: &'a [Magnitudes],
}

/// Codes a part of a band. `out` gets its coefficients, and has zeros before. Returns their magnitudes.
///
/// # Errors
/// The bytes are corrupt.
pub fn code<S: Side>(
    side: &mut S,
    models: &mut Models,
    known: Known<'_>,
    extent: [usize; 3],
    out: &mut [i32],
) -> Result<Magnitudes, Fault> {
    let [nx, ny, nz] = extent;
    let mut own = Magnitudes::new(extent);
    let mut activity = vec![0_u16; nx];
    for (y, z) in (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))) {
        own.activity((y, z), known.parents, known.done, &mut activity);
        let start = (z * ny + y) * nx;
        let magnitudes = own.row_mut(y, z);
        let (mut before, mut x, mut busy) = (0, 0, false);
        while x < nx {
            let end = nx.min(x + SEGMENT);
            let quiet = before == 0 && activity[x..end].iter().all(|a| *a == 0);
            if quiet && !side.segment(models, start + x..start + end)? {
                x = end;
                continue;
            }
            for i in x..end {
                let place = start + i;
                let negative = || {
                    let sign = |there: bool, back: usize| if there { out[place - back] } else { 0 };
                    (known.number, signs([sign(i > 0, 1), sign(y > 0, nx), sign(z > 0, nx * ny)]))
                };
                let value = side.coefficient(models, place, class(activity[i] + NEAR * before), negative)?;
                before = counted(value);
                if value != 0 {
                    out[place] = value;
                    magnitudes[i] = before;
                    busy = true;
                }
            }
            x = end;
        }
        own.set_busy(y, z, busy);
    }
    Ok(own)
}
