//! Tests of what all metrics of pictures share, and of the first of them.

use super::metric::Metric;
use super::*;
use crate::metrics::shifted;

/// Two pictures that `tests/picture_metrics.py` paints too, in steps of 1/255: waves of three frequencies, and the same
/// in fewer steps, with a square that is brighter.
pub(super) fn painted([width, height]: [u32; 2]) -> [Image; 2] {
    let wave = |n: i64| (n.rem_euclid(512) - 256).abs().min(255);
    let pixel = |x: i64, y: i64| [wave(5 * x + 2 * y), wave(3 * x - 4 * y + 80), wave(x * x / 16 + 9 * y)];
    let coarse = |x: i64, y: i64| {
        let lift = if x % 40 < 12 && y % 50 < 20 { 24 } else { 0 };
        pixel(x, y).map(|v| (v / 32 * 32 + 16 + lift).min(255))
    };
    let paint = |colour: &dyn Fn(i64, i64) -> [i64; 3]| {
        let places = (0..i64::from(height)).flat_map(|y| (0..i64::from(width)).map(move |x| (x, y)));
        let pixels = places.map(|(x, y)| {
            let [r, g, b] = colour(x, y).map(|v| v as f32 / 255.0);
            [r, g, b, 1.0]
        });
        Image::from_pixels([width, height], pixels.collect()).unwrap()
    };
    [paint(&pixel), paint(&coarse)]
}

/// A metric over the whole frame.
pub(super) fn whole<M: Metric>(reference: &Image, image: &Image) -> Option<f64> {
    let (a, b) = (reference.over(BLACK), image.over(BLACK));
    let size = reference.size().map(|n| n as usize);
    M::value(&M::compare(&Pair { size, reference: &a, image: &b }), a.len() as f64)
}

/// Holds a metric to numbers that another program has computed of [`painted`] pictures, and that a picture shifted by a
/// pixel must not have.
pub(super) fn assert_agrees<M: Metric>(expected: &[([u32; 2], f64)], tolerance: f64) {
    for &(size, expected) in expected {
        let [a, b] = painted(size);
        let own = whole::<M>(&a, &b).unwrap();
        assert!((own - expected).abs() < tolerance, "{size:?}: {own} for {expected}");
        let other = whole::<M>(&b, &shifted(&b, 1, 0)).unwrap();
        assert!((other - expected).abs() > 1e-3, "{size:?}: {other}");
    }
}

const BLACK: [f32; 3] = [0.0; 3];

/// A disc with a pattern, on nothing.
fn disc(size: u32) -> Image {
    let mut image = Image::new([size, size]);
    let centre = size as f32 / 2.0;
    for y in 0..size {
        for x in 0..size {
            let (u, v) = (x as f32 + 0.5 - centre, y as f32 + 0.5 - centre);
            if u.hypot(v) < centre * 0.5 {
                let tone = 0.5 + 0.3 * (u * 0.9).sin() * (v * 0.7).cos();
                image.pixels_mut()[(y * size + x) as usize] = [tone, tone * 0.8, 0.3, 1.0];
            }
        }
    }
    image
}

#[test]
fn equal_pictures_are_identical_and_one_step_of_eight_bits_is_noticed() {
    let a = disc(40);
    let equal = ImageError::compare(&a, &a, BLACK).unwrap();
    assert_eq!((equal.psnr_db, equal.psnr_whole_db), (f64::INFINITY, f64::INFINITY));
    assert_eq!((equal.ssim, equal.ssim_whole), (1.0, 1.0));

    let mut b = a.clone();
    let middle = 20 * 40 + 20;
    (0..3).for_each(|c| b.pixels_mut()[middle][c] += 1.0 / 255.0);
    let off = ImageError::compare(&a, &b, BLACK).unwrap();
    assert!(off.psnr_db.is_finite() && off.ssim < 1.0, "{off:?}");
    // PSNR compares the floats themselves; SSIM, on 8 bits, cannot see one bit.
    b.pixels_mut()[middle] = a.pixels()[middle];
    b.pixels_mut()[middle][1] = f32::from_bits(a.pixels()[middle][1].to_bits() + 1);
    assert!(ImageError::compare(&a, &b, BLACK).unwrap().psnr_db.is_finite());
}

#[test]
fn a_shift_of_one_pixel_costs_much() {
    let a = disc(64);
    let off = ImageError::compare(&a, &shifted(&a, 1, 0), BLACK).unwrap();
    assert!(off.psnr_db < 30.0 && off.ssim < 0.95, "{off:?}");
    assert!(off.psnr_whole_db > off.psnr_db && off.ssim_whole > off.ssim);
}

#[test]
fn error_is_divided_by_the_visible_pixels_of_the_reference() {
    let mut a = Image::new([10, 10]);
    a.pixels_mut()[0] = [0.5, 0.5, 0.5, 1.0];
    a.pixels_mut()[1] = [0.001, 0.001, 0.001, 1.0 / 511.0]; // rounds to nothing
    let mut b = a.clone();
    b.pixels_mut()[99] = [0.1, 0.1, 0.1, 1.0]; // stray, where the reference shows nothing
    let error = ImageError::compare(&a, &b, BLACK).unwrap();
    assert_eq!(error.visible_pixels, 1);
    assert!((error.psnr_db - 20.0).abs() < 1e-5, "{error:?}");
    assert!((error.psnr_whole_db - 40.0).abs() < 1e-5, "{error:?}");
    // Drawing more does not help: only the reference's pixels count.
    let swapped = ImageError::compare(&b, &a, BLACK).unwrap();
    assert!(swapped.psnr_db > error.psnr_db);
}

#[test]
fn blank_pictures_are_identical_and_drawing_on_nothing_is_an_error() {
    let blank = Image::new([8, 8]);
    let equal = ImageError::compare(&blank, &blank, [1.0; 3]).unwrap();
    assert_eq!((equal.psnr_db, equal.ssim, equal.visible_pixels), (f64::INFINITY, 1.0, 0));
    let mut drawn = blank.clone();
    drawn.pixels_mut()[3] = [0.0, 0.0, 0.0, 1.0];
    let error = ImageError::compare(&blank, &drawn, [1.0; 3]).unwrap();
    assert!(error.psnr_db.abs() < 1e-6 && error.ssim < 1.0, "{error:?}");
    assert!(ImageError::compare(&Image::new([0, 0]), &Image::new([0, 0]), BLACK).is_ok());
}

#[test]
fn sizes_must_agree() {
    let error = ImageError::compare(&Image::new([2, 3]), &Image::new([3, 2]), BLACK).unwrap_err();
    assert_eq!(error.to_string(), "pictures of 2×3 and 3×2 pixels cannot be compared");
}

/// Two pictures side by side are one of twice the width, whose tiles of SSIM are the same.
#[test]
fn pooled_pictures_are_one_picture() {
    let (a, b) = (disc(32), shifted(&disc(32), 0, 3));
    let beside = |left: &Image, right: &Image| {
        let mut both = Image::new([64, 32]);
        for y in 0..32 {
            both.pixels_mut()[y * 64..y * 64 + 32].copy_from_slice(&left.pixels()[y * 32..(y + 1) * 32]);
            both.pixels_mut()[y * 64 + 32..(y + 1) * 64]
                .copy_from_slice(&right.pixels()[y * 32..(y + 1) * 32]);
        }
        both
    };
    let empty = Image::new([32, 32]);
    for (second, other) in [(&b, &a), (&a, &a), (&empty, &a)] {
        let whole = ImageError::compare(&beside(&a, second), &beside(&b, other), BLACK).unwrap();
        let parts = [(&a, &b), (second, other)].map(|(a, b)| ImageError::compare(a, b, BLACK).unwrap());
        let pooled = ImageError::pooled(parts.into_iter());
        assert_eq!(pooled.visible_pixels, whole.visible_pixels);
        // A picture of nothing counts as one visible pixel.
        let tolerance = if second == &empty { 0.03 } else { 1e-9 };
        for (pooled, whole) in [
            (pooled.psnr_db, whole.psnr_db),
            (pooled.psnr_whole_db, whole.psnr_whole_db),
            (pooled.ssim, whole.ssim),
            (pooled.ssim_whole, whole.ssim_whole),
        ] {
            assert!((pooled - whole).abs() < tolerance, "{pooled} for {whole}");
        }
    }
}

#[test]
fn further_metrics_are_divided_by_visible_pixels_too() {
    let (a, b) = (disc(64), shifted(&disc(64), 1, 0));
    let error = ImageError::compare(&a, &b, BLACK).unwrap();
    let values: Vec<_> =
        error.values(Against::Reference).map(|(name, value)| (name, value.unwrap())).collect();
    let names: Vec<_> = values.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["image_ms_ssim", "image_ms_ssim_whole", "image_flip", "image_flip_whole"]);
    let (similar, flip) = ([values[0].1, values[1].1], [values[2].1, values[3].1]);
    assert!(similar[0] < similar[1] && similar[1] < 1.0, "{similar:?}");
    let share = 64.0 * 64.0 / error.visible_pixels as f64;
    assert!((flip[0] - flip[1] * share).abs() < 1e-12 && flip[1] > 0.0, "{flip:?}");
    let raw: Vec<_> = error.values(Against::Raw).collect();
    assert_eq!(raw, [("codec_image_ms_ssim", Some(similar[0])), ("codec_image_flip", Some(flip[0]))]);
    // Twice the same picture is the same.
    let pooled = ImageError::pooled([error, error].into_iter());
    for ((_, one), (_, two)) in error.values(Against::Reference).zip(pooled.values(Against::Reference)) {
        assert!((one.unwrap() - two.unwrap()).abs() < 1e-12);
    }
    let equal = ImageError::compare(&a, &a, BLACK).unwrap();
    assert!(equal.values(Against::Reference).map(|(_, value)| value.unwrap()).eq([1.0, 1.0, 0.0, 0.0]));
}
