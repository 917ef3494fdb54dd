//! Tests of what all metrics of pictures share, and of the first of them.

use super::metric::Metric;
use super::*;
use crate::metrics::shifted;

/// Two pictures that `tests/painted.py` paints too, in steps of 1/255: waves of three frequencies, and the same
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
    M::value(&M::compare(&Pair { size, reference: &a, image: &b }), Per::Whole(a.len() as f64))
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

/// PSNR per visible pixel and of the whole frame, and SSIM likewise.
fn figures_of(error: &ImageError) -> [Option<f64>; 4] {
    let values: Vec<_> = error.values(Against::Reference).map(|(_, value)| value).collect();
    assert_eq!((error.psnr_db(), error.ssim()), (values[0], values[2]));
    [values[0], values[1], values[2], values[3]]
}

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
    let infinite = Some(f64::INFINITY);
    assert_eq!(figures_of(&equal), [infinite, infinite, Some(1.0), Some(1.0)]);

    let mut b = a.clone();
    let middle = 20 * 40 + 20;
    (0..3).for_each(|c| b.pixels_mut()[middle][c] += 1.0 / 255.0);
    let off = ImageError::compare(&a, &b, BLACK).unwrap();
    let [psnr, psnr_whole, ssim, ssim_whole] = figures_of(&off).map(Option::unwrap);
    assert!(psnr.is_finite() && psnr < psnr_whole && ssim < ssim_whole && ssim_whole < 1.0, "{off:?}");
    // The floats themselves are compared.
    b.pixels_mut()[middle] = a.pixels()[middle];
    b.pixels_mut()[middle][1] = f32::from_bits(a.pixels()[middle][1].to_bits() + 1);
    assert!(ImageError::compare(&a, &b, BLACK).unwrap().psnr_db().unwrap().is_finite());
}

#[test]
fn a_shift_of_one_pixel_costs_much() {
    let a = disc(64);
    let off = ImageError::compare(&a, &shifted(&a, 1, 0), BLACK).unwrap();
    let [psnr, psnr_whole, ssim, ssim_whole] = figures_of(&off).map(Option::unwrap);
    assert!(psnr < 30.0 && ssim < 0.95, "{off:?}");
    assert!(psnr_whole > psnr && ssim_whole > ssim);
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
    let [psnr, psnr_whole, ..] = figures_of(&error).map(Option::unwrap_or_default);
    assert!((psnr - 20.0).abs() < 1e-5 && (psnr_whole - 40.0).abs() < 1e-5, "{error:?}");
    // Drawing more does not help: only the reference's pixels count.
    let swapped = ImageError::compare(&b, &a, BLACK).unwrap();
    assert!(swapped.psnr_db() > error.psnr_db());
}

/// A reference that shows nothing cannot judge a picture, black or not.
#[test]
fn nothing_is_compared_with_a_reference_that_shows_nothing() {
    let blank = Image::new([16, 16]);
    let mut drawn = blank.clone();
    drawn.pixels_mut()[3] = [0.0, 0.0, 0.0, 1.0];
    for (image, squared) in [(&blank, 0.0), (&drawn, 3.0)] {
        let error = ImageError::compare(&blank, image, [1.0; 3]).unwrap();
        assert_eq!((error.visible_pixels, error.squared_error()), (0, squared));
        assert_eq!((error.psnr_db(), error.ssim()), (None, None));
        for against in [Against::Reference, Against::Raw] {
            assert!(error.values(against).count() >= 4 && error.values(against).all(|(_, v)| v.is_none()));
        }
    }
    // One visible pixel is enough, and the same picture the other way round is judged.
    let error = ImageError::compare(&drawn, &blank, [1.0; 3]).unwrap();
    assert!(
        error.psnr_db().unwrap().abs() < 1e-6 && error.values(Against::Reference).all(|(_, v)| v.is_some())
    );
    let empty = Image::new([0, 0]);
    assert_eq!(ImageError::compare(&empty, &empty, BLACK).unwrap().psnr_db(), None);
}

#[test]
fn sizes_must_agree() {
    let error = ImageError::compare(&Image::new([2, 3]), &Image::new([3, 2]), BLACK).unwrap_err();
    assert_eq!(error.to_string(), "pictures of 2×3 and 3×2 pixels cannot be compared");
}

/// Two pictures side by side form one of twice the width. No window sees both. Errors beside a reference that shows
/// nothing count in the whole.
#[test]
fn pooled_pictures_are_one_picture() {
    let (a, b) = (disc(64), shifted(&disc(64), 0, 3));
    let beside = |left: &Image, right: &Image| {
        let mut both = Image::new([128, 64]);
        for y in 0..64 {
            both.pixels_mut()[y * 128..y * 128 + 64].copy_from_slice(&left.pixels()[y * 64..(y + 1) * 64]);
            both.pixels_mut()[y * 128 + 64..(y + 1) * 128]
                .copy_from_slice(&right.pixels()[y * 64..(y + 1) * 64]);
        }
        both
    };
    let empty = Image::new([64, 64]);
    for (second, other) in [(&b, &a), (&a, &a), (&empty, &a), (&empty, &empty)] {
        let whole = ImageError::compare(&beside(&a, second), &beside(&b, other), BLACK).unwrap();
        let parts = [(&a, &b), (second, other)].map(|(a, b)| ImageError::compare(a, b, BLACK).unwrap());
        let pooled = ImageError::pooled(parts.into_iter());
        assert_eq!(pooled.visible_pixels, whole.visible_pixels);
        // Windows lie inside at 118 places along x, and at 54 of each half.
        let inner = |ssim: f64, places: f64| (1.0 - ssim) * places;
        let [[psnr, psnr_whole, ssim, ssim_whole], one] =
            [&pooled, &whole].map(|error| figures_of(error).map(Option::unwrap));
        for (pooled, whole) in [
            (psnr, one[0]),
            (psnr_whole, one[1]),
            (ssim, one[2]),
            (inner(ssim_whole, 108.0), inner(one[3], 118.0)),
        ] {
            assert!((pooled - whole).abs() < 1e-9, "{pooled} for {whole}");
        }
    }
    let nothing = [ImageError::compare(&empty, &a, BLACK).unwrap(); 2];
    assert_eq!(figures_of(&ImageError::pooled(nothing.into_iter())), [None; 4]);
}

#[test]
fn further_metrics_are_divided_by_visible_pixels_too() {
    let (a, b) = (disc(64), shifted(&disc(64), 1, 0));
    let error = ImageError::compare(&a, &b, BLACK).unwrap();
    let values: Vec<_> =
        error.values(Against::Reference).map(|(name, value)| (name, value.unwrap())).collect();
    let names: Vec<_> = values.iter().map(|(name, _)| *name).collect();
    assert_eq!(names[..4], ["image_psnr_db", "image_psnr_whole_db", "image_ssim", "image_ssim_whole"]);
    assert_eq!(names[4..], ["image_ms_ssim", "image_ms_ssim_whole", "image_flip", "image_flip_whole"]);
    let values = &values[4..];
    let (similar, flip) = ([values[0].1, values[1].1], [values[2].1, values[3].1]);
    assert!(similar[0] < similar[1] && similar[1] < 1.0, "{similar:?}");
    let share = 64.0 * 64.0 / error.visible_pixels as f64;
    assert!((flip[0] - flip[1] * share).abs() < 1e-12 && flip[1] > 0.0, "{flip:?}");
    let raw: Vec<_> = error.values(Against::Raw).collect();
    assert_eq!(raw[..2], [("codec_image_psnr_db", error.psnr_db()), ("codec_image_ssim", error.ssim())]);
    assert_eq!(raw[2..], [("codec_image_ms_ssim", Some(similar[0])), ("codec_image_flip", Some(flip[0]))]);
    // Twice the same picture is the same.
    let pooled = ImageError::pooled([error, error].into_iter());
    for ((_, one), (_, two)) in error.values(Against::Reference).zip(pooled.values(Against::Reference)) {
        assert!((one.unwrap() - two.unwrap()).abs() < 1e-12);
    }
    let equal = ImageError::compare(&a, &a, BLACK).unwrap();
    let further = equal.values(Against::Reference).skip(4);
    assert!(further.map(|(_, value)| value.unwrap()).eq([1.0, 1.0, 0.0, 0.0]));
}
