//! One transform of a bundle of lines, side by side.

use super::filter::{Extension, Filter, Half, Kernel, Step};

/// Lines in a bundle. Each operation on a sample is one on as many lanes.
pub const LANES: usize = 16;

/// The samples of a bundle at one place.
pub type Row<T> = [T; LANES];

/// A bundle of lines, its samples at even and at odd places apart. A transform turns them into low and high bands.
#[derive(Clone, Debug, Default)]
pub struct Bundle<T> {
    /// Even samples, or the low band.
    pub even: Vec<Row<T>>,
    /// Odd samples, or the high band.
    pub odd: Vec<Row<T>>,
    spare: [Vec<Row<T>>; 2],
}

/// A type of samples that a filter transforms.
pub trait Sample: Copy + Default + Send + Sync + std::fmt::Debug {
    /// The type that a volume is transformed in. It is wider where transforms round, so that a coefficient rounds once.
    type Wide: Wide;

    /// The same value.
    fn widen(self) -> Self::Wide;

    /// The nearest value.
    fn round(wide: Self::Wide) -> Self;
}

/// A type that volumes are transformed in.
pub trait Wide: Sample<Wide = Self> {
    /// Transforms a bundle of more than one sample per line, of which there are as many odd as even ones or one less.
    fn forward(filter: &Prepared, bundle: &mut Bundle<Self>);

    /// The inverse.
    fn inverse(filter: &Prepared, bundle: &mut Bundle<Self>);
}

/// A filter with its weights in single precision.
#[derive(Clone, Debug)]
pub struct Prepared {
    extension: Extension,
    kernel: PreparedKernel,
}

#[derive(Clone, Debug)]
enum PreparedKernel {
    Lifting(Vec<(Step, Vec<f64>)>),
    /// Taps of both filters. Sums are taken in double precision: there are no steps to undo one by one.
    Orthonormal([Vec<f64>; 2]),
    Integer,
}

impl Prepared {
    /// A filter made ready.
    #[must_use]
    pub fn new(filter: Filter) -> Self {
        let single = |taps: &[f64]| taps.to_vec();
        let kernel = match filter.kernel() {
            Kernel::Lifting(steps) => {
                PreparedKernel::Lifting(steps.iter().map(|step| (*step, single(step.taps))).collect())
            }
            Kernel::Orthonormal(low) => {
                let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
                let high: Vec<f64> = low.iter().rev().enumerate().map(|(k, tap)| sign(k) * tap).collect();
                PreparedKernel::Orthonormal([low.to_vec(), high])
            }
            Kernel::Integer => PreparedKernel::Integer,
        };
        Self { extension: filter.extension(), kernel }
    }
}

/// Place in its half of the sample `at` places from the start of a half. `n` samples are in the line, `odd` says which
/// half. May lie outside the line. `None` if a sample there adds nothing: the last sample of a line of odd length,
/// repeated beyond the end, has no difference from itself.
fn extended(extension: Extension, at: isize, odd: bool, n: usize) -> Option<usize> {
    let (n, odd) = (n as isize, isize::from(odd));
    Some(match extension {
        Extension::Periodic => at.rem_euclid(n / 2) as usize,
        Extension::HalfSample if odd == 1 && 2 * at + 1 >= n => return None,
        Extension::HalfSample => at.clamp(0, (n - 1 - odd) / 2) as usize,
        Extension::Symmetric => {
            let place = (2 * at + odd).rem_euclid(2 * (n - 1));
            (place.min(2 * (n - 1) - place) / 2) as usize
        }
    })
}

/// Adds `sign · Σ taps · from` to every row of `to`. `odd` says whether `from` is the odd half.
fn lift(
    to: &mut [Row<f64>],
    from: &[Row<f64>],
    (first, taps, sign): (isize, &[f64], f64),
    extension: Extension,
    odd: bool,
) {
    let n = to.len() + from.len();
    let inside = |i: usize| {
        let start = i as isize + first;
        start >= 0 && start as usize + taps.len() <= from.len()
    };
    for (i, to) in to.iter_mut().enumerate() {
        let mut sum = [0.0; LANES];
        let mut add = |tap: f64, row: &Row<f64>| {
            for (sum, v) in sum.iter_mut().zip(row) {
                *sum += tap * v;
            }
        };
        if inside(i) {
            let start = (i as isize + first) as usize;
            taps.iter().zip(&from[start..]).for_each(|(tap, row)| add(*tap, row));
        } else {
            for (k, tap) in taps.iter().enumerate() {
                if let Some(at) = extended(extension, i as isize + first + k as isize, odd, n) {
                    add(*tap, &from[at]);
                }
            }
        }
        for (to, sum) in to.iter_mut().zip(sum) {
            *to += sign * sum;
        }
    }
}

fn step(bundle: &mut Bundle<f64>, (step, taps): &(Step, Vec<f64>), sign: f64, extension: Extension) {
    let Bundle { even, odd, .. } = bundle;
    match step.to {
        Half::Even => lift(even, odd, (step.first, taps, sign), extension, true),
        Half::Odd => lift(odd, even, (step.first, taps, sign), extension, false),
    }
}

/// Rows of the two bands of an orthonormal filter.
fn analyse(bundle: &mut Bundle<f64>, taps: &[Vec<f64>; 2]) {
    let Bundle { even, odd, spare } = bundle;
    let half = even.len();
    for (spare, taps) in spare.iter_mut().zip(taps) {
        spare.clear();
        spare.extend((0..half).map(|i| {
            let mut sum = [0.0_f64; LANES];
            for (k, tap) in taps.iter().enumerate() {
                let from = if k % 2 == 0 { &even } else { &odd };
                let row = &from[(i + k / 2) % half];
                sum.iter_mut().zip(row).for_each(|(sum, v)| *sum += tap * *v);
            }
            sum
        }));
    }
    std::mem::swap(even, &mut spare[0]);
    std::mem::swap(odd, &mut spare[1]);
}

/// The inverse: twice the transpose of the analysis.
fn synthesise(bundle: &mut Bundle<f64>, taps: &[Vec<f64>; 2]) {
    let Bundle { even, odd, spare } = bundle;
    let half = even.len();
    for (parity, spare) in spare.iter_mut().enumerate() {
        spare.clear();
        spare.extend((0..half).map(|i| {
            let mut sum = [0.0_f64; LANES];
            for (band, taps) in [&*even, &*odd].into_iter().zip(taps) {
                for (k, tap) in taps.iter().skip(parity).step_by(2).enumerate() {
                    let row = &band[(i + half * taps.len() - k) % half];
                    sum.iter_mut().zip(row).for_each(|(sum, v)| *sum += tap * *v);
                }
            }
            sum.map(|v| 2.0 * v)
        }));
    }
    std::mem::swap(even, &mut spare[0]);
    std::mem::swap(odd, &mut spare[1]);
}

impl Sample for f32 {
    type Wide = f64;

    fn widen(self) -> f64 {
        f64::from(self)
    }

    fn round(wide: f64) -> Self {
        wide as Self
    }
}

impl Sample for f64 {
    type Wide = Self;

    fn widen(self) -> Self {
        self
    }

    fn round(wide: Self) -> Self {
        wide
    }
}

impl Wide for f64 {
    fn forward(filter: &Prepared, bundle: &mut Bundle<Self>) {
        match &filter.kernel {
            PreparedKernel::Lifting(steps) => {
                steps.iter().for_each(|s| step(bundle, s, 1.0, filter.extension));
            }
            PreparedKernel::Orthonormal(taps) => analyse(bundle, taps),
            PreparedKernel::Integer => {}
        }
    }

    fn inverse(filter: &Prepared, bundle: &mut Bundle<Self>) {
        match &filter.kernel {
            PreparedKernel::Lifting(steps) => {
                steps.iter().rev().for_each(|s| step(bundle, s, -1.0, filter.extension));
            }
            PreparedKernel::Orthonormal(taps) => synthesise(bundle, taps),
            PreparedKernel::Integer => {}
        }
    }
}

/// Changes every row of `to` by a function of the two rows of `from` around it, which lie `first` and `first + 1`
/// places from it.
fn lift_integers(
    to: &mut [Row<i32>],
    from: &[Row<i32>],
    (first, odd): (isize, bool),
    change: impl Fn(&mut i32, i32),
) {
    let n = to.len() + from.len();
    for (i, to) in to.iter_mut().enumerate() {
        let at = |k| extended(Extension::Symmetric, i as isize + first + k, odd, n).unwrap_or(i);
        let (a, b) = (&from[at(0)], &from[at(1)]);
        for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
            change(to, a.wrapping_add(*b));
        }
    }
}

impl Sample for i32 {
    type Wide = Self;

    fn widen(self) -> Self {
        self
    }

    fn round(wide: Self) -> Self {
        wide
    }
}

/// JPEG 2000 part 1, equations F-5 and F-6. Arithmetic wraps, so hostile coefficients end in wrong samples only.
impl Wide for i32 {
    fn forward(_: &Prepared, bundle: &mut Bundle<Self>) {
        let Bundle { even, odd, .. } = bundle;
        lift_integers(odd, even, (0, false), |d, sum| *d = d.wrapping_sub(sum >> 1));
        lift_integers(even, odd, (-1, true), |s, sum| *s = s.wrapping_add(sum.wrapping_add(2) >> 2));
    }

    fn inverse(_: &Prepared, bundle: &mut Bundle<Self>) {
        let Bundle { even, odd, .. } = bundle;
        lift_integers(even, odd, (-1, true), |s, sum| *s = s.wrapping_sub(sum.wrapping_add(2) >> 2));
        lift_integers(odd, even, (0, false), |d, sum| *d = d.wrapping_add(sum >> 1));
    }
}
