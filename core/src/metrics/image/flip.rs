//! FLIP: the difference that an eye sees when two pictures alternate.
//!
//! After P. Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", Proc. ACM Comput. Graph. Interact.
//! Tech. 3 (2), 2020, for pictures of low dynamic range (section 4), which are taken to be sRGB as they are shown; section
//! and equation numbers below are of that paper. The display is the paper's: 0.7 m away, 3840 pixels on 0.7 m, so 67
//! pixels per degree. Borders are repeated. This is a new implementation: the authors' C++, or a binding to it, would need
//! another compiler than Rust's. A test compares it with numbers of the authors' program.

use super::gaussian::{Plane, gaussian};
use super::metric::{Metric, Pair, Per};
use crate::metrics::{Better, Figure};

/// Pixels per degree of visual angle.
const PIXELS_PER_DEGREE: f64 = 0.7 * (3840.0 / 0.7) * std::f64::consts::PI / 180.0;
/// Contrast sensitivity of each opponent channel as a sum of Gaussians (section 4.1.1, table 1): pairs of a and b.
const SENSITIVITY: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
/// Exponent of colour differences (section 4.1.3).
const COLOUR_EXPONENT: f64 = 0.7;
/// Share of the largest difference up to which differences are stretched, and to what (section 4.1.3).
const STRETCHED: [f64; 2] = [0.4, 0.95];
/// Width of a feature in degrees (section 4.2.1).
const FEATURE_DEGREES: f64 = 0.082;
/// Exponent of feature differences (section 4.2.2).
const FEATURE_EXPONENT: f64 = 0.5;
/// Linear sRGB to XYZ, white D65.
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// The metric.
pub(super) struct Flip;

const fn figure(
    name: &'static str,
    heading: &'static str,
    axis: &'static str,
    definition: &'static str,
) -> Figure {
    Figure { name, heading, axis, unit: "1", better: Better::Lower, definition }
}

impl Metric for Flip {
    const FIGURES: [Figure; 3] = [
        figure(
            "image_flip",
            "picture FLIP",
            "FLIP of the picture",
            "Σf ÷ visible pixels, with the f of `image_flip_whole`",
        ),
        figure(
            "image_flip_whole",
            "whole-frame FLIP",
            "FLIP of the whole frame",
            "mean over all pixels of the difference f (0 to 1) of Andersson et al. 2020, at 67 pixels per degree",
        ),
        figure(
            "codec_image_flip",
            "codec's picture FLIP",
            "FLIP of the picture against raw",
            "`image_flip` against raw's picture under the same site and filter",
        ),
    ];
    /// Sum of the differences, and the pixels that have one.
    type Sums = (f64, u64);

    fn compare(pair: &Pair<'_>) -> (f64, u64) {
        if pair.reference.is_empty() {
            return (0.0, 0);
        }
        let [reference, image] = [pair.reference, pair.image].map(|rgb| Opponent::new(rgb, pair.size));
        let colours = [&reference, &image].map(Opponent::seen_colours);
        let features = [&reference, &image].map(|opponent| Features::of(&opponent.channels[0]));
        let largest = largest_difference();
        let differences = (0..pair.reference.len()).map(|i| {
            let colour = stretched(difference(colours[0][i], colours[1][i]), largest);
            let feature = features[0].difference(&features[1], i);
            let both = colour.powf(1.0 - feature);
            // A value that is not a number has the largest error.
            if both.is_nan() { 1.0 } else { both }
        });
        (differences.sum(), pair.reference.len() as u64)
    }

    fn add(sums: &mut (f64, u64), next: (f64, u64)) {
        sums.0 += next.0;
        sums.1 += next.1;
    }

    fn value(sums: &(f64, u64), per: Per) -> Option<f64> {
        (sums.1 > 0).then(|| sums.0 / per.pixels())
    }
}

/// A picture in the opponent space YCxCz (section 4.1.1).
struct Opponent {
    channels: [Plane; 3],
}

impl Opponent {
    fn new(rgb: &[[f32; 3]], size: [usize; 2]) -> Self {
        let opponent: Vec<[f64; 3]> = rgb
            .iter()
            .map(|rgb| {
                let [x, y, z] = relative_xyz(rgb.map(|v| linear(f64::from(v))));
                [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
            })
            .collect();
        let channels = [0, 1, 2].map(|c| Plane { size, values: opponent.iter().map(|p| p[c]).collect() });
        Self { channels }
    }

    /// L*a*b* of each pixel after the filters of contrast sensitivity, with a* and b* adjusted for the Hunt effect
    /// (sections 4.1.1 and 4.1.2).
    fn seen_colours(&self) -> Vec<[f64; 3]> {
        let pi = std::f64::consts::PI;
        let widest = SENSITIVITY.iter().copied().flatten().map(|(_, b)| *b).fold(0.0, f64::max);
        let radius = (3.0 * (widest / (2.0 * pi * pi)).sqrt() * PIXELS_PER_DEGREE).ceil() as usize;
        let filtered: Vec<Plane> = self
            .channels
            .iter()
            .zip(SENSITIVITY)
            .map(|(channel, gaussians)| {
                // a √(π/b) exp(−π² x² / b) with x in degrees is a Gaussian of σ = √(b/2) / π; that of two dimensions
                // has the weight a √(π/b) (Σ exp)² before all are divided by their sum.
                let kernels: Vec<(f64, Vec<f64>)> = gaussians
                    .iter()
                    .map(|(a, b)| {
                        let sigma = (b / 2.0).sqrt() / pi * PIXELS_PER_DEGREE;
                        let at = |i: usize| i as f64 - radius as f64;
                        let sum: f64 =
                            (0..=2 * radius).map(|i| (-at(i) * at(i) / (2.0 * sigma * sigma)).exp()).sum();
                        (a * (pi / b).sqrt() * sum * sum, gaussian(sigma, radius))
                    })
                    .collect();
                let total: f64 = kernels.iter().map(|(weight, _)| weight).sum();
                let mut sum = channel.map(|_| 0.0);
                for (weight, kernel) in kernels {
                    let part = channel.whole(&kernel, &kernel).values;
                    sum.values.iter_mut().zip(part).for_each(|(sum, v)| *sum += weight / total * v);
                }
                sum
            })
            .collect();
        let pixel = |i: usize| {
            let [y, cx, cz] = [0, 1, 2].map(|c| filtered[c].values[i]);
            let y = (y + 16.0) / 116.0;
            adjusted(linear_rgb([y + cx / 500.0, y, y - cz / 200.0]).map(|v| v.clamp(0.0, 1.0)))
        };
        (0..filtered[0].values.len()).map(pixel).collect()
    }
}

/// Strength of edges and of points (section 4.2.1).
struct Features {
    edges: Vec<f64>,
    points: Vec<f64>,
}

impl Features {
    /// Those of a luminance from −16 to 100.
    fn of(luminance: &Plane) -> Self {
        let plane = luminance.map(|y| (y + 16.0) / 116.0);
        let sigma = 0.5 * FEATURE_DEGREES * PIXELS_PER_DEGREE;
        let radius = (3.0 * sigma).ceil() as usize;
        let smooth = gaussian(sigma, radius);
        let at = |i: usize| i as f64 - radius as f64;
        let first = balanced(smooth.iter().zip(0..).map(|(g, i)| -at(i) * g));
        let second =
            balanced(smooth.iter().zip(0..).map(|(g, i)| (at(i) * at(i) / (sigma * sigma) - 1.0) * g));
        let strength = |kernel: &[f64]| -> Vec<f64> {
            let (x, y) = (plane.whole(kernel, &smooth), plane.whole(&smooth, kernel));
            x.values.iter().zip(y.values).map(|(x, y)| x.hypot(y)).collect()
        };
        Self { edges: strength(&first), points: strength(&second) }
    }

    /// Difference of the features of a pixel, 0 to 1 (section 4.2.2).
    fn difference(&self, other: &Self, i: usize) -> f64 {
        let edge = (self.edges[i] - other.edges[i]).abs();
        let point = (self.points[i] - other.points[i]).abs();
        // `f64::max` would drop a NaN.
        let larger = if edge.is_nan() { edge } else { edge.max(point) };
        (larger / std::f64::consts::SQRT_2).powf(FEATURE_EXPONENT)
    }
}

/// Weights whose positive ones sum to 1 and whose negative ones to −1.
fn balanced(weights: impl Iterator<Item = f64>) -> Vec<f64> {
    let weights: Vec<f64> = weights.collect();
    let positive: f64 = weights.iter().filter(|w| **w > 0.0).sum();
    let negative: f64 = weights.iter().filter(|w| **w < 0.0).sum();
    weights.into_iter().map(|w| if w > 0.0 { w / positive } else { -w / negative }).collect()
}

/// sRGB (IEC 61966-2-1) to light.
fn linear(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// XYZ of light, each relative to white.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    TO_XYZ.map(|row| {
        let white: f64 = row.iter().sum();
        row.iter().zip(rgb).map(|(m, v)| m * v).sum::<f64>() / white
    })
}

/// Light of XYZ relative to white: the inverse, by Cramer's rule.
fn linear_rgb(relative: [f64; 3]) -> [f64; 3] {
    let m = TO_XYZ;
    let xyz = [0, 1, 2].map(|r| relative[r] * m[r].iter().sum::<f64>());
    let determinant = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let whole = determinant(m);
    [0, 1, 2].map(|column| {
        let mut replaced = m;
        (0..3).for_each(|row| replaced[row][column] = xyz[row]);
        determinant(replaced) / whole
    })
}

/// L*a*b* of light, with a* and b* scaled by L* ÷ 100.
fn adjusted(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(rgb).map(|t| {
        let delta = 6.0 / 29.0;
        if t > delta * delta * delta { t.cbrt() } else { t / (3.0 * delta * delta) + 4.0 / 29.0 }
    });
    let lightness = 116.0 * y - 16.0;
    [lightness, 500.0 * (x - y) * 0.01 * lightness, 200.0 * (y - z) * 0.01 * lightness]
}

/// HyAB distance to the power of [`COLOUR_EXPONENT`] (section 4.1.3).
fn difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    ((a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])).powf(COLOUR_EXPONENT)
}

/// The largest of such differences: green against blue.
fn largest_difference() -> f64 {
    difference(adjusted([0.0, 1.0, 0.0]), adjusted([0.0, 0.0, 1.0]))
}

/// A difference as a share of the largest, the small ones stretched (section 4.1.3).
fn stretched(difference: f64, largest: f64) -> f64 {
    let [share, to] = STRETCHED;
    let knee = share * largest;
    if difference < knee {
        to / knee * difference
    } else {
        to + (difference - knee) / (largest - knee) * (1.0 - to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::image::tests::{assert_agrees, whole};
    use crate::render::Image;

    /// Numbers of `tests/picture_metrics.py`, from the authors' program.
    #[test]
    fn agrees_with_the_authors_program() {
        assert_agrees::<Flip>(&FLIP, 2e-5);
    }

    const FLIP: [([u32; 2], f64); 4] =
        [([192, 180], 0.175_846), ([203, 161], 0.174_508), ([100, 90], 0.192_329), ([31, 11], 0.240_614)];

    #[test]
    fn equal_pictures_have_none_and_green_against_blue_has_all() {
        let of = |rgb: [f32; 3]| Image::from_pixels([9, 7], vec![[rgb[0], rgb[1], rgb[2], 1.0]; 63]).unwrap();
        let (green, blue) = (of([0.0, 1.0, 0.0]), of([0.0, 0.0, 1.0]));
        assert_eq!(whole::<Flip>(&green, &green), Some(0.0));
        assert!((whole::<Flip>(&green, &blue).unwrap() - 1.0).abs() < 1e-9);
        // By hand: black and white are 100 apart in L*, 41 in 203^0.7, beyond the knee.
        let black_white = whole::<Flip>(&of([0.0; 3]), &of([1.0; 3])).unwrap();
        let largest = largest_difference();
        let expected = 0.95 + (100.0_f64.powf(0.7) - 0.4 * largest) / (0.6 * largest) * 0.05;
        assert!((black_white - expected).abs() < 1e-9, "{black_white} for {expected}");
        assert!(black_white < 0.99);
        assert_eq!(whole::<Flip>(&green, &of([f32::NAN; 3])), Some(1.0));
        assert_eq!(whole::<Flip>(&Image::new([0, 0]), &Image::new([0, 0])), None);
    }
}
