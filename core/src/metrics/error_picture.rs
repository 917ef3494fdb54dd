//! The error picture of S3Dc (Yela, Navazo & Vázquez 2008): where a picture differs, and by how much.
//!
//! A pixel's error is the largest difference of its three channels after compositing, as a fraction of full scale
//! (a mean would hide an error of one channel). No error is black. Within the first class the blue brightens with
//! the error, for most of a good codec's errors lie there and one flat blue would show nothing; the other classes
//! are flat, as printed.

use super::SizeMismatch;
use crate::render::Image;

/// One colour of the error picture.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ErrorClass {
    /// Text of the legend.
    pub label: &'static str,
    /// Upper end of the class as a fraction of full scale; not part of it.
    pub below: f32,
    /// Colour (of the first class: its brightest).
    pub rgb: [u8; 3],
}

/// The four classes in rising order. In the first one the colour fades to `FAINTEST`.
pub const ERROR_CLASSES: [ErrorClass; 4] = [
    ErrorClass { label: "below 5 %", below: 0.05, rgb: [70, 120, 255] },
    ErrorClass { label: "5–10 %", below: 0.10, rgb: [30, 180, 80] },
    ErrorClass { label: "10–15 %", below: 0.15, rgb: [250, 215, 40] },
    ErrorClass { label: "15 % and more", below: f32::INFINITY, rgb: [225, 40, 40] },
];

/// The blue of the smallest error that is drawn.
const FAINTEST: [u8; 3] = [12, 18, 70];
/// Errors up to half a step of 8 bits do not show in a picture: black.
const INVISIBLE: f32 = 1.0 / 510.0;

/// Colour of an error, given as a fraction of full scale. A value that is not a number is drawn as the largest error.
#[must_use]
pub fn error_colour(error: f32) -> [u8; 3] {
    if error <= INVISIBLE {
        return [0; 3];
    }
    let [blue, .., red] = ERROR_CLASSES;
    if error < blue.below {
        let t = (error - INVISIBLE) / (blue.below - INVISIBLE);
        let fade =
            |low: u8, high: u8| (f32::from(low) + (f32::from(high) - f32::from(low)) * t).round() as u8;
        return std::array::from_fn(|c| fade(FAINTEST[c], blue.rgb[c]));
    }
    ERROR_CLASSES.iter().find(|class| error < class.below).unwrap_or(&red).rgb
}

/// The error picture as 8-bit RGB rows, for [`write_png`](crate::render::write_png).
///
/// # Errors
/// When the pictures differ in size.
pub fn error_picture(
    reference: &Image,
    image: &Image,
    background: [f32; 3],
) -> Result<Vec<u8>, SizeMismatch> {
    SizeMismatch::check(reference, image)?;
    let largest = |a: &[f32; 3], b: &[f32; 3]| {
        let differences = [0, 1, 2].map(|c| (a[c] - b[c]).abs());
        differences.into_iter().fold(0.0, |m: f32, d| if d.is_nan() || d > m { d } else { m })
    };
    let (a, b) = (reference.over(background), image.over(background));
    Ok(a.iter().zip(&b).flat_map(|(a, b)| error_colour(largest(a, b))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_begin_where_the_paper_says() {
        let [blue, green, yellow, red] = ERROR_CLASSES.map(|class| class.rgb);
        assert_eq!(error_colour(0.0), [0; 3]);
        for (error, rgb) in
            [(0.05, green), (0.0999, green), (0.10, yellow), (0.1499, yellow), (0.15, red), (1.0, red)]
        {
            assert_eq!(error_colour(error), rgb, "{error}");
        }
        assert_eq!(error_colour(0.049_999_9), blue);
        assert_eq!(error_colour(f32::NAN), red);
    }

    #[test]
    fn small_errors_show_and_brighten() {
        let steps: Vec<u8> = (1..12).map(|i| error_colour(i as f32 / 255.0)[2]).collect();
        assert!(steps[0] >= 70 && steps.is_sorted_by(|a, b| a < b), "{steps:?}");
    }

    #[test]
    fn shows_the_largest_channel_at_its_place() {
        let a = Image::new([3, 1]);
        let mut b = a.clone();
        b.pixels_mut()[1] = [0.0, 0.12, 0.01, 0.0];
        let picture = error_picture(&a, &b, [0.0; 3]).unwrap();
        assert_eq!(picture[..3], [0; 3]);
        assert_eq!(picture[3..6], ERROR_CLASSES[2].rgb);
        assert_eq!(picture[6..], [0; 3]);
        assert!(error_picture(&a, &Image::new([1, 3]), [0.0; 3]).is_err());
    }
}
