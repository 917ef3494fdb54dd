//! Monotone piecewise cubic interpolation.
//!
//! F. N. Fritsch, R. E. Carlson: Monotone Piecewise Cubic Interpolation. SIAM Journal on Numerical Analysis 17 (2), 1980.
//! Slopes at inner knots are the weighted harmonic means of F. N. Fritsch, J. Butland: A Method for Constructing Local
//! Monotone Piecewise Cubic Interpolants. SIAM Journal on Scientific and Statistical Computing 5 (2), 1984; those at both
//! ends are three-point differences that keep the shape, as in SciPy's `PchipInterpolator`.

/// An interpolant that rises and falls only where its knots do.
#[derive(Clone, Debug, PartialEq)]
pub struct Pchip {
    x: Vec<f64>,
    y: Vec<f64>,
    slope: Vec<f64>,
}

impl Pchip {
    /// Through knots `(x, y)`; `None` for fewer than two, for `x` that do not strictly rise, and for what is not finite.
    #[must_use]
    pub fn new(knots: &[(f64, f64)]) -> Option<Self> {
        let finite = knots.iter().all(|(x, y)| x.is_finite() && y.is_finite());
        let rising = knots.windows(2).all(|w| w[0].0 < w[1].0);
        if knots.len() < 2 || !finite || !rising {
            return None;
        }
        let (x, y): (Vec<f64>, Vec<f64>) = knots.iter().copied().unzip();
        let slope = slopes(&x, &y);
        Some(Self { x, y, slope })
    }

    /// First and last knot.
    #[must_use]
    pub fn domain(&self) -> [f64; 2] {
        [self.x[0], self.x[self.x.len() - 1]]
    }

    /// The value at `x`, which is moved into the domain.
    #[must_use]
    pub fn at(&self, x: f64) -> f64 {
        let x = x.clamp(self.x[0], self.x[self.x.len() - 1]);
        let (i, h, t) = self.piece(x);
        let (t2, t3) = (t * t, t * t * t);
        self.y[i] * (2.0 * t3 - 3.0 * t2 + 1.0)
            + h * self.slope[i] * (t3 - 2.0 * t2 + t)
            + self.y[i + 1] * (3.0 * t2 - 2.0 * t3)
            + h * self.slope[i + 1] * (t3 - t2)
    }

    /// The integral over `[low, high]`, both moved into the domain; in closed form, piece by piece.
    #[must_use]
    pub fn integral(&self, low: f64, high: f64) -> f64 {
        self.up_to(high) - self.up_to(low)
    }

    /// The integral from the first knot to `x`.
    fn up_to(&self, x: f64) -> f64 {
        let (last, h, t) = self.piece(x.clamp(self.x[0], self.x[self.x.len() - 1]));
        let whole: f64 = (0..last).map(|i| self.part(i, self.x[i + 1] - self.x[i], 1.0)).sum();
        whole + self.part(last, h, t)
    }

    /// The integral of piece `i`, of width `h`, over its first share `t`.
    fn part(&self, i: usize, h: f64, t: f64) -> f64 {
        let (t2, t3, t4) = (t * t, t * t * t, t * t * t * t);
        h * (self.y[i] * (t4 / 2.0 - t3 + t)
            + h * self.slope[i] * (t4 / 4.0 - 2.0 * t3 / 3.0 + t2 / 2.0)
            + self.y[i + 1] * (t3 - t4 / 2.0)
            + h * self.slope[i + 1] * (t4 / 4.0 - t3 / 3.0))
    }

    /// The piece of the domain that contains `x`: its number, its width, and the fraction of it before `x`.
    fn piece(&self, x: f64) -> (usize, f64, f64) {
        let i = self.x.partition_point(|knot| *knot <= x).clamp(1, self.x.len() - 1) - 1;
        let h = self.x[i + 1] - self.x[i];
        (i, h, (x - self.x[i]) / h)
    }
}

/// Slopes at all knots.
fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let h: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
    let secant: Vec<f64> = y.windows(2).zip(&h).map(|(w, h)| (w[1] - w[0]) / h).collect();
    let last = secant.len() - 1;
    if last == 0 {
        return vec![secant[0]; 2];
    }
    let mut slope = vec![end(h[0], h[1], secant[0], secant[1])];
    for k in 1..=last {
        let (before, after) = (secant[k - 1], secant[k]);
        slope.push(if before * after <= 0.0 {
            0.0
        } else {
            let (w1, w2) = (2.0 * h[k] + h[k - 1], h[k] + 2.0 * h[k - 1]);
            (w1 + w2) / (w1 / before + w2 / after)
        });
    }
    slope.push(end(h[last], h[last - 1], secant[last], secant[last - 1]));
    slope
}

/// The slope at an end, from the two pieces next to it, the outer one first.
fn end(h0: f64, h1: f64, m0: f64, m1: f64) -> f64 {
    let slope = ((2.0 * h0 + h1) * m0 - h0 * m1) / (h0 + h1);
    if slope * m0 <= 0.0 {
        0.0
    } else if m0 * m1 <= 0.0 && slope.abs() > 3.0 * m0.abs() {
        3.0 * m0
    } else {
        slope
    }
}
